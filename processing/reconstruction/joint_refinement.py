"""The joint refinement: edges between all views that overlap, found and not assumed, and one pose for each view."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise as successive

import numpy as np

from orbitscan.processing.reconstruction.pose_graph import (
    GraphSettings,
    Solution,
    choose_edges,
    solve,
    viewing_direction,
)
from orbitscan.processing.reconstruction.self_registration import find_self_symmetries, tell_by_color
from orbitscan.processing.reconstruction.trajectory import Hints
from orbitscan.processing.reconstruction.view_judgement import bound_centers, judge_views
from orbitscan.processing.registration.ambiguity.known_step import distrust, is_refuted
from orbitscan.processing.registration.ambiguity.symmetry import find_agreed, is_turn, join
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.registration.competition import challenge
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import PreparedView, ViewCache
from orbitscan.processing.registration.unobservable import same_freedom
from orbitscan.processing.results.estimates import (
    Freedom,
    MethodResult,
    PairEstimate,
    Symmetry,
    UsualMisfit,
    ViewEstimate,
)
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

_ROUND = np.radians(330)  # turned on the way there and straight back: a whole turn, less what a tilted camera saves
Register = Callable[[PreparedView, PreparedView, Hints], PairEstimate]  # source, target, and what is known of them


def refine_jointly(
    pairwise: MethodResult,
    origin: int | None,
    cache: ViewCache,
    register: Register,
    pair_settings: PairSettings,
    settings: GraphSettings,
) -> MethodResult:
    """Refine all views of a session together, starting from the pairs of successive views; T_0_origin = I.

    A view that its own pair does not connect is registered to others; then every view to those it should overlap; then
    the graph is solved. What all views together tell of the object's symmetries is looked for in every edge. A view is
    `ok` where edges that leave nothing open lead from it to the origin, `ambiguous` where others do, `not_connected`
    where none do.
    """
    if origin is None:
        return MethodResult.of(pairwise.views, (), origin)
    graph = _Graph(origin, cache, register, pair_settings, settings, cache.get_surface(origin).scale.diameter)
    graph.refuted_step = is_refuted(pairwise.pairs)
    graph.edges = [pair for pair in map(graph.judge, pairwise.pairs) if _is_edge(pair)]
    graph.solve()
    candidates = [v.view for v in pairwise.views if v.status not in (Status.UNREADABLE, Status.TOO_FEW_POINTS)]
    graph.attach(candidates)
    graph.solve()
    graph.close()
    graph.solve()
    graph.register_with_itself()
    solution, edges = graph.solution, graph.edges
    kept = [edge for edge, keep in zip(edges, solution.kept, strict=True) if keep]
    left_out = [edge for edge, keep in zip(edges, solution.kept, strict=True) if not keep]
    contradicting = [edge for edge in (*left_out, *graph.refuted) if edge.status == Status.OK]
    placed = [_estimate(view, solution, origin) for view in pairwise.views]
    views = judge_views(placed, kept, origin, graph.diameter, contradicting)
    shown = [_mark(edge, keep) for edge, keep in zip(edges, solution.kept, strict=True)]
    shown += [_mark(edge, keep=False) for edge in graph.refuted]
    freedoms = _find_freedoms(solution, edges, graph.diameter, settings)
    return MethodResult.of(
        views,
        bound_centers(shown, views),
        origin,
        loop_closed=_goes_round(solution, edges, [v.view for v in pairwise.views]),
        freedoms=freedoms,
        symmetries=tuple(s for s in graph.symmetries if not is_turn(freedoms, s, graph.diameter)),
    )


@dataclass
class _Graph:
    """The edges found so far, what they tell together, and what more of them are found with."""

    origin: int
    cache: ViewCache
    register: Register
    pair_settings: PairSettings
    settings: GraphSettings
    diameter: float  # of the object [m]
    edges: list[PairEstimate] = field(default_factory=list)
    symmetries: list[Symmetry] = field(default_factory=list)  # of the object, in frame {0}
    refuted: list[PairEstimate] = field(default_factory=list)  # that seem right, but for what the others say
    refuted_step: bool = False  # whether the pairs decide against the user's step
    solution: Solution = field(default_factory=lambda: Solution({}, frozenset(), ()))

    def judge(self, pair: PairEstimate) -> PairEstimate:
        """A pair, after what the others say of the user's step."""
        return distrust(pair) if self.refuted_step else pair

    def solve(self) -> None:
        """Solve the graph of the edges found so far."""
        self.solution = solve(self.edges, self.origin, self.diameter, self.settings)

    def attach(self, candidates: Sequence[int]) -> None:
        """Find edges that connect the views which none connects yet, each to a placed one, until no more can be.

        Where the views nearly slide, as mugs with hidden handles do, only a neighbour in time vouches for such an edge.
        """
        placed = [view for view in candidates if view in self.solution.rigid]
        lost = [view for view in candidates if view not in self.solution.rigid]
        kept = [edge for edge, keep in zip(self.edges, self.solution.kept, strict=True) if keep]
        held = {frozenset((edge.source, edge.target)) for edge in kept if edge.status == Status.OK}
        tried: set[tuple[int, int]] = set()
        open_: dict[int, int] = {}  # how many pairs of a view leave something open
        progress = True
        while lost and progress:
            progress = False
            for view in list(lost):
                if any(frozenset((view, other)) in held for other in placed):  # to one that was attached just now
                    placed.append(view)
                    lost.remove(view)
                    progress = True
                    continue
                likely = sorted(placed, key=lambda other: (abs(other - view), other))[: self.settings.tries]
                for other in likely:
                    if (view, other) in tried or open_.get(view, 0) >= self.settings.open_tries:
                        continue
                    tried.add((view, other))
                    edge = self._register(view, other, {})
                    open_[view] = open_.get(view, 0) + (edge.status == Status.AMBIGUOUS)
                    near = abs(other - view) <= self.settings.vouching
                    if edge.status == Status.OK and (near or self._holds(edge)):
                        self.edges.append(edge)
                        placed.append(view)
                        lost.remove(view)
                        progress = True
                        break

    def close(self) -> None:
        """Find edges between views that should overlap by their poses; other starts compete with these."""
        solution, directions = self.solution, {}
        for view in sorted(solution.rigid):
            T_0_i = solution.T_0[view]
            surface = self.cache.get_surface(view).surface
            directions[view] = viewing_direction(T_0_i, surface.surfels.points.mean(axis=0), surface.sensor_origin)
        known = [(edge.source, edge.target) for edge in self.edges]
        for source, target in choose_edges(directions, known, self.settings):
            start = poses.invert(solution.T_0[target]) @ solution.T_0[source]
            edge = self._register(source, target, {"graph": start})
            if edge.status != Status.OK or edge.T_target_source is None:
                continue
            if self._pair(edge).distance(edge.T_target_source, start) <= 1.0:
                self.edges.append(edge)
            else:
                self.refuted.append(edge)

    def register_with_itself(self) -> None:
        """Find the symmetries of the whole object, and look for them in every edge: some seem to leave nothing open."""
        T_0 = self.solution.T_0
        holding = [edge for edge, keep in zip(self.edges, self.solution.kept, strict=True) if keep]
        if not holding:
            return
        usual = sorted(holding, key=lambda edge: edge.evidence.misfit or 0.0)[len(holding) // 2]
        if usual.T_target_source is None:
            return
        pair = self._pair(usual)
        explained, colors = pair.explain(usual.T_target_source), ColorPair.of(pair)
        colored = None if colors is None else colors.explain(usual.T_target_source)
        told = [symmetry.moved(T_0[e.target]) for e in holding if e.target in T_0 for symmetry in e.symmetries]
        turns = [symmetry.turns()[0] for symmetry in told]
        self.symmetries = find_self_symmetries(self.cache, T_0, turns, explained, self.pair_settings)
        self.symmetries = join(self.symmetries, find_agreed(told, len(holding) / 2, self.diameter), self.diameter)
        self.symmetries = tell_by_color(self.cache, T_0, self.symmetries, colored, self.pair_settings)
        if self.symmetries:
            self.edges = [self.judge(self._challenge(edge)) for edge in self.edges]
            self.solve()

    def _register(self, source: int, target: int, starts: Mapping[str, np.ndarray]) -> PairEstimate:
        usual = UsualMisfit.of([edge for edge in self.edges if edge.status == Status.OK])
        return self.judge(
            self.register(self.cache.get(source), self.cache.get(target), Hints(starts, usual, only_ok=True))
        )

    def _challenge(self, edge: PairEstimate) -> PairEstimate:
        """An edge, or what symmetries of the object make of it."""
        T = self.solution.T_0.get(edge.target)
        suspected = [] if T is None else [symmetry.moved(poses.invert(T)) for symmetry in self.symmetries]
        return challenge(self._pair(edge), edge, suspected)

    def _pair(self, edge: PairEstimate) -> PairRegistration:
        source, target = self.cache.get_surface(edge.source), self.cache.get_surface(edge.target)
        return PairRegistration(source, target, self.pair_settings)

    def _holds(self, edge: PairEstimate) -> bool:
        """Whether the overlap holds the edge's weakest motion more firmly than views that nearly slide do."""
        observability = edge.evidence.observability
        return observability is not None and observability >= self.pair_settings.symmetry.suspicious


def _is_edge(pair: PairEstimate) -> bool:
    """Whether a pair holds two views together: it is right, or right but for what the views leave open."""
    return pair.status.is_believed and pair.information is not None


def _estimate(view: ViewEstimate, solution: Solution, origin: int) -> ViewEstimate:
    """Return a view as the solution places it."""
    T_0_i = solution.T_0.get(view.view)
    if T_0_i is None:
        refuted = view.status == Status.INCONSISTENT and view.note is not None
        told = refuted or view.status in (Status.UNREADABLE, Status.TOO_FEW_POINTS)
        lost = view.status if told else Status.NOT_CONNECTED
        return ViewEstimate(view.view, lost, None, note=view.note)
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
