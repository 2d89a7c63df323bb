"""What the pairs of `pairwise` are worth when the whole session is known.

A symmetry of the object leaves pairs open that seemed to leave nothing open, and pairs together may refute the user's
step; what hangs on such a pair is no longer connected.
"""

from collections.abc import Sequence

import numpy as np

from orbitscan.processing.reconstruction.trajectory import compose
from orbitscan.processing.reconstruction.view_judgement import bound_centers, judge_views
from orbitscan.processing.registration.ambiguity.known_step import distrust, is_refuted
from orbitscan.processing.registration.competition import challenge
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import ViewCache
from orbitscan.processing.results.estimates import MethodResult, PairEstimate, Symmetry, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses


def reconsider(
    found: MethodResult, refined: MethodResult | None, cache: ViewCache, settings: PairSettings
) -> MethodResult:
    """Return the result of pairs one after the other as the whole session bears it out.

    A refused pair is right that `refined` found again; the object's symmetries, which it knows, are looked for in every
    pair; where the pairs refute the user's step none goes by it; and every view is judged (see `judge_views`). Frame
    {0} is that of `refined`.
    """
    if found.origin is None:
        return found
    origin = refined.origin if refined else None
    symmetries = refined.symmetries if refined else ()
    pairs = [_confirm(pair, refined, cache, settings) for pair in found.pairs]
    T_0 = {view.view: view.T_0_i for view in _compose(found.views, pairs, origin)}
    pairs = [_challenge(pair, T_0.get(pair.target), symmetries, cache, settings) for pair in pairs]
    if is_refuted(pairs):
        pairs = [distrust(pair) for pair in pairs]
    views = _compose(found.views, pairs, origin)
    if origin is None:
        origin = next(view.view for view in views if view.status == Status.OK)
    views = judge_views(views, pairs, origin, cache.get_surface(origin).scale.diameter)
    return MethodResult.of(views, bound_centers(pairs, views), origin, symmetries=symmetries)


def _compose(views: Sequence[ViewEstimate], pairs: Sequence[PairEstimate], origin: int | None) -> list[ViewEstimate]:
    return compose(views, pairs, [pair for pair in pairs if pair.status.is_believed], origin)


def _confirm(
    pair: PairEstimate, refined: MethodResult | None, cache: ViewCache, settings: PairSettings
) -> PairEstimate:
    """A refused pair as the joint refinement found it, where that is right and in the same place."""
    if refined is None or pair.status.is_believed or pair.T_target_source is None:
        return pair
    ends = pair.source, pair.target
    for other in refined.pairs:
        if (other.source, other.target) == ends and other.status == Status.OK and other.T_target_source is not None:
            views = PairRegistration(cache.get_surface(pair.source), cache.get_surface(pair.target), settings)
            return other if views.distance(pair.T_target_source, other.T_target_source) <= 1.0 else pair
    return pair


def _challenge(
    pair: PairEstimate,
    T_0_target: np.ndarray | None,
    symmetries: Sequence[Symmetry],
    cache: ViewCache,
    settings: PairSettings,
) -> PairEstimate:
    if not symmetries or T_0_target is None or not pair.status.is_believed:
        return pair
    views = PairRegistration(cache.get_surface(pair.source), cache.get_surface(pair.target), settings)
    return challenge(views, pair, [symmetry.moved(poses.invert(T_0_target)) for symmetry in symmetries])
