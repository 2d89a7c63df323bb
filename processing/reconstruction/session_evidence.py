"""What the pairs of `pairwise` are worth when the whole session is known.

A symmetry of the object leaves pairs open that seemed to leave nothing open, and pairs together may refute the user's
step; what hangs on such a pair is no longer connected.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orbitscan.processing.reconstruction.view_judgement import bound_centers, judge_views
from orbitscan.processing.registration.ambiguity.known_step import distrust, is_refuted
from orbitscan.processing.registration.competition import challenge
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import ViewCache
from orbitscan.processing.results.estimates import MethodResult, PairEstimate, Symmetry
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses


def reconsider(
    found: MethodResult, refined: MethodResult | None, origin: int | None, cache: ViewCache, settings: PairSettings
) -> MethodResult:
    """Return the result of pairs one after the other as the whole session bears it out.

    The object's symmetries, which `refined` knows, are looked for in every pair; where the pairs refute the user's step
    none goes by it; and every view is judged (see `judge_views`).
    """
    if origin is None:
        return found
    symmetries = refined.symmetries if refined else ()
    T_0 = {view.view: view.T_0_i for view in found.views}
    pairs = [_challenge(pair, T_0.get(pair.target), symmetries, cache, settings) for pair in found.pairs]
    if is_refuted(pairs):
        pairs = [distrust(pair) for pair in pairs]
    own = {pair.source: pair for pair in pairs}
    connected, views = {origin}, []
    for view in found.views:
        status = view.status
        if (placed_by := own.get(view.view)) is not None and status.is_believed:
            hangs = placed_by.status == Status.OK and placed_by.target not in connected
            status = Status.NOT_CONNECTED if hangs else placed_by.status
        if status == Status.OK:
            connected.add(view.view)
        views.append(replace(view, status=status))
    views = judge_views(views, pairs, origin, cache.get_surface(origin).scale.diameter)
    return MethodResult.of(views, bound_centers(pairs, views), origin, symmetries=symmetries)


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
