"""The joint refinement: edges between all views that overlap, found and not assumed, and one pose for each view."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise as successive

import numpy as np

from orbitscan.processing.reconstruction.pose_graph import (
    GraphSettings,
    Solution,
    choose_edges,
    solve,
    viewing_direction,
)
from orbitscan.processing.reconstruction.trajectory import usual_misfit
from orbitscan.processing.registration.competition import register_from, verify_sliding
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import PreparedView, ViewCache
from orbitscan.processing.registration.unobservable import same_freedom
from orbitscan.processing.results.estimates import Freedom, MethodResult, PairEstimate, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

_ROUND = np.radians(330)  # turned on the way there and straight back: a whole turn, less what a tilted camera saves

Register = Callable[[PreparedView, PreparedView], PairEstimate]  # source and target, without a guess


def refine_jointly(
    pairwise: MethodResult,
    origin: int | None,
    cache: ViewCache,
    register: Register,
    pair_settings: PairSettings,
    settings: GraphSettings,
) -> MethodResult:
    """Refine all views of a session together, starting from the pairs of successive views; T_0_origin = I.

    A view that its own pair does not connect is registered to others; then every view to those it should overlap, by
    the poses so far; then the graph is solved. A view is `ok` where rigid edges lead from it to the origin, `ambiguous`
    where only edges with a free motion do, `not_connected` where none do.
    """
    if origin is None:
        return MethodResult.of(pairwise.views, (), origin)
    diameter = cache.get_surface(origin).scale.diameter
    candidates = [v.view for v in pairwise.views if v.status not in (Status.UNREADABLE, Status.TOO_FEW_POINTS)]
    edges = [pair for pair in pairwise.pairs if _is_edge(pair)]
    solution = solve(edges, origin, diameter, settings)
    edges += _attach(candidates, edges, solution, cache, register, pair_settings, settings)
    solution = solve(edges, origin, diameter, settings)
    edges += _close(solution, edges, cache, pair_settings, settings)
    solution = solve(edges, origin, diameter, settings)
    return MethodResult.of(
        [_estimate(view, solution) for view in pairwise.views],
        [_mark(edge, keep) for edge, keep in zip(edges, solution.kept, strict=True)],
        origin,
        loop_closed=_goes_round(solution, edges, [v.view for v in pairwise.views]),
        freedoms=_find_freedoms(solution, edges, diameter, settings),
    )


def _is_edge(pair: PairEstimate) -> bool:
    """Whether a pair holds two views together: it is right, or right but for free motions."""
    sound = pair.status == Status.OK or (pair.status == Status.AMBIGUOUS and pair.freedoms and not pair.alternatives)
    return bool(sound) and pair.information is not None


def _attach(
    candidates: Sequence[int],
    edges: Sequence[PairEstimate],
    solution: Solution,
    cache: ViewCache,
    register: Register,
    pair_settings: PairSettings,
    settings: GraphSettings,
) -> list[PairEstimate]:
    """Find edges that connect the views which none connects yet, each to a placed one, until no more can be.

    Where the views nearly slide, as mugs with hidden handles do, only a neighbour in time vouches for such an edge.
    """
    slides = pair_settings.symmetry.suspicious
    usual = usual_misfit(edges)
    placed = [view for view in candidates if view in solution.rigid]
    lost = [view for view in candidates if view not in solution.rigid]
    tried: set[tuple[int, int]] = set()
    found: list[PairEstimate] = []
    progress = True
    while lost and progress:
        progress = False
        for view in list(lost):
            likely = sorted(placed, key=lambda other: (abs(other - view), other))[: settings.tries]
            for other in likely:
                if (view, other) in tried:
                    continue
                tried.add((view, other))
                edge = verify_sliding(register(cache.get(view), cache.get(other)), usual, pair_settings)
                near = abs(other - view) <= settings.vouching
                if edge.status == Status.OK and _is_edge(edge) and (near or _holds(edge, slides)):
                    found.append(edge)
                    placed.append(view)
                    lost.remove(view)
                    progress = True
                    break
    return found


def _holds(edge: PairEstimate, slides: float) -> bool:
    """Whether the overlap holds the edge's weakest motion more firmly than views that nearly slide do."""
    return edge.evidence.observability is not None and edge.evidence.observability >= slides


def _close(
    solution: Solution,
    edges: Sequence[PairEstimate],
    cache: ViewCache,
    pair_settings: PairSettings,
    settings: GraphSettings,
) -> list[PairEstimate]:
    """Find edges between views that should overlap by their poses, each registered from there."""
    directions, usual = {}, usual_misfit(edges)
    for view in sorted(solution.rigid):
        T_0_i = solution.T_0[view]
        surface = cache.get_surface(view).surface
        directions[view] = viewing_direction(T_0_i, surface.surfels.points.mean(axis=0), surface.sensor_origin)
    found = []
    for source, target in choose_edges(directions, [(e.source, e.target) for e in edges], settings):
        start = poses.invert(solution.T_0[target]) @ solution.T_0[source]
        pair = PairRegistration(cache.get_surface(source), cache.get_surface(target), pair_settings)
        edge = verify_sliding(register_from(pair, {"graph": start}), usual, pair_settings)
        if _is_edge(edge):
            found.append(edge)
    return found


def _estimate(view: ViewEstimate, solution: Solution) -> ViewEstimate:
    """Return a view as the solution places it."""
    T_0_i = solution.T_0.get(view.view)
    if T_0_i is None:
        status = view.status if view.status in (Status.UNREADABLE, Status.TOO_FEW_POINTS) else Status.NOT_CONNECTED
        return ViewEstimate(view.view, status, None)
    return ViewEstimate(view.view, Status.OK if view.view in solution.rigid else Status.AMBIGUOUS, T_0_i)


def _mark(edge: PairEstimate, keep: bool) -> PairEstimate:
    """Return an edge as it is, or as one that the others contradict."""
    return edge if keep else replace(edge, status=Status.INCONSISTENT)


def _goes_round(solution: Solution, edges: Sequence[PairEstimate], views: Sequence[int]) -> bool:
    """Whether an edge joins two views between which the views on the way turn all the way round."""
    placed = [view for view in views if view in solution.T_0]
    turns = [poses.rotation_angle(solution.T_0[a][:3, :3].T @ solution.T_0[b][:3, :3]) for a, b in successive(placed)]
    turned = dict(zip(placed, np.concatenate([[0.0], np.cumsum(turns)]), strict=True))
    kept = [e for e, keep in zip(edges, solution.kept, strict=True) if keep]
    ends = [(e.source, e.target) for e in kept if e.source in turned and e.target in turned]
    return any(
        abs(turned[a] - turned[b]) + poses.rotation_angle(solution.T_0[a][:3, :3].T @ solution.T_0[b][:3, :3]) > _ROUND
        for a, b in ends
        if abs(turned[a] - turned[b]) > np.pi
    )


def _find_freedoms(
    solution: Solution, edges: Sequence[PairEstimate], diameter: float, settings: GraphSettings
) -> tuple[Freedom, ...]:
    """Find the free motions, in frame {0}, of views that no rigid edges connect to the origin; each once."""
    found: list[Freedom] = []
    near = settings.same_axis_deg, settings.same_axis_shift * diameter
    for edge in edges:
        if edge.source in solution.rigid and edge.target in solution.rigid:
            continue
        T = solution.T_0.get(edge.target)
        if T is None:
            continue
        for freedom in edge.freedoms:
            axis, point = T[:3, :3] @ freedom.axis, poses.transform(T, freedom.point[None])[0]
            moved = Freedom(freedom.kind, axis, point)
            if not any(same_freedom(moved, other, *near) for other in found):
                found.append(moved)
    return tuple(found)
