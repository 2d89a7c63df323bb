"""What a whole session tells of its views and pairs, when all of them are registered.

A symmetry of the object leaves pairs open that seemed to leave nothing open; how well a pose is known depends on all
pairs that lead to it; and where nothing moves, what was registered may be what stands still.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from orbitscan.processing.reconstruction.graph_uncertainty import measure_graph
from orbitscan.processing.registration.ambiguity.known_step import distrust, is_refuted
from orbitscan.processing.registration.competition import challenge
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import ViewCache
from orbitscan.processing.results.estimates import MethodResult, PairEstimate, Symmetry, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

_STILL_DEG, _STILL_SHARE = 1.0, 0.01  # a view that turns and shifts (share of the diameter) by less stands still
STILL = "nothing moves from view to view: what was registered may be what stands still"


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
    return MethodResult.of(views, pairs, origin, symmetries=symmetries)


def judge_views(
    views: Sequence[ViewEstimate], pairs: Sequence[PairEstimate], origin: int, diameter: float
) -> list[ViewEstimate]:
    """Return views with their bounds, `ambiguous` where these allow an ok one to be wrong.

    Where nothing moves from view to view they are `inconsistent`. `pairs` are those that nothing contradicts; the ok
    ones connect all ok views. The diameter [m] is the object's.
    """
    T_0 = {view.view: view.T_0_i for view in views if view.status == Status.OK and view.T_0_i is not None}
    holding = [pair for pair in pairs if pair.status == Status.OK and pair.source in T_0 and pair.target in T_0]
    centers = _find_centers(holding, T_0)
    if len(T_0) > 1 and not any(_moves(T, centers[view], diameter) for view, T in T_0.items() if view != origin):
        still = T_0.keys() - {origin}
        return [replace(v, status=Status.INCONSISTENT, note=STILL) if v.view in still else v for v in views]
    judged, bounds = [], measure_graph(holding, T_0, centers, origin)
    for view in views:
        if view.view == origin:
            view = replace(view, rotation_bound_deg=0.0, center_bound_m=0.0)
        elif known := bounds.get(view.view):
            status = Status.OK if known.is_good(diameter) else Status.AMBIGUOUS
            turn, shift = known.rotation_bound_deg, known.center_bound_m
            view = replace(view, status=status, rotation_bound_deg=turn, center_bound_m=shift)
        judged.append(view)
    return judged


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


def _find_centers(pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray]) -> dict[int, np.ndarray]:
    """Find for each view the middle of its points (3,), in frame {0}: of a pair's source, where it is one."""
    centers: dict[int, np.ndarray] = {}
    for pair in pairs:
        if pair.center is not None:
            center = poses.transform(T_0[pair.target], pair.center[None])[0]
            centers[pair.source] = center
            centers.setdefault(pair.target, center)
    return centers


def _moves(T_0_i: np.ndarray, center: np.ndarray, diameter: float) -> bool:
    """Whether a view is turned, or its points' centre (3,) shifted, against the first view."""
    shift = float(np.linalg.norm(center - poses.transform(poses.invert(T_0_i), center[None])[0]))
    return bool(np.degrees(poses.rotation_angle(T_0_i[:3, :3])) > _STILL_DEG or shift > _STILL_SHARE * diameter)
