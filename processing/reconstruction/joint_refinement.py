"""The joint refinement: edges between all views that overlap, found and not assumed, and one pose for each view."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise as successive

import numpy as np

from orbitscan.processing.reconstruction.graph_uncertainty import measure_graph
from orbitscan.processing.reconstruction.pose_graph import (
    GraphSettings,
    Solution,
    choose_edges,
    solve,
    viewing_direction,
)
from orbitscan.processing.reconstruction.self_registration import find_self_symmetries
from orbitscan.processing.reconstruction.trajectory import Hints
from orbitscan.processing.registration.competition import challenge
from orbitscan.processing.registration.known_step import distrust, is_refuted
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import PreparedView, ViewCache
from orbitscan.processing.registration.symmetry import find_agreed, join
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
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.recorder import poses

_ROUND = np.radians(330)  # turned on the way there and straight back: a whole turn, less what a tilted camera saves
_STILL_DEG, _STILL_SHARE = 1.0, 0.01  # a view that turns and shifts (share of the diameter) by less stands still
STILL = "nothing moves from view to view: what was registered may be what stands still"

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
    bounds = graph.measure()
    views = [_estimate(view, solution, bounds, origin, graph.diameter) for view in pairwise.views]
    return MethodResult.of(
        refuse_stillness(views, origin, cache),
        [*(_mark(edge, keep) for edge, keep in zip(edges, solution.kept, strict=True)), *graph.refuted],
        origin,
        loop_closed=_goes_round(solution, edges, [v.view for v in pairwise.views]),
        freedoms=_find_freedoms(solution, edges, graph.diameter, settings),
        symmetries=tuple(graph.symmetries),
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
        tried: set[tuple[int, int]] = set()
        open_: dict[int, int] = {}  # how many pairs of a view leave something open
        progress = True
        while lost and progress:
            progress = False
            for view in list(lost):
                likely = sorted(placed, key=lambda other: (abs(other - view), other))[: self.settings.tries]
                for other in likely:
                    if (view, other) in tried or open_.get(view, 0) >= self.settings.open_tries:
                        continue
                    tried.add((view, other))
                    edge = self._register(view, other, None)
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
            edge = self._register(source, target, start)
            if edge.status != Status.OK or edge.T_target_source is None:
                continue
            if self._pair(edge).distance(edge.T_target_source, start) <= 1.0:
                self.edges.append(edge)
            else:
                self.refuted.append(_mark(edge, keep=False))

    def register_with_itself(self) -> None:
        """Find the symmetries of the whole object, and look for them in every edge: some seem to leave nothing open."""
        T_0 = self.solution.T_0
        holding = [edge for edge, keep in zip(self.edges, self.solution.kept, strict=True) if keep]
        if not holding:
            return
        usual = sorted(holding, key=lambda edge: edge.evidence.misfit or 0.0)[len(holding) // 2]
        if usual.T_target_source is None:
            return
        explained = self._pair(usual).explain(usual.T_target_source)
        views = {view: self.cache.get_surface(view) for view in T_0}
        told = [symmetry.moved(T_0[e.target]) for e in holding if e.target in T_0 for symmetry in e.symmetries]
        turns = [symmetry.turns()[0] for symmetry in told]
        self.symmetries = find_self_symmetries(views, T_0, turns, explained, self.pair_settings)
        self.symmetries = join(self.symmetries, find_agreed(told, len(holding) / 2, self.diameter), self.diameter)
        if self.symmetries:
            self.edges = [self.judge(self._challenge(edge)) for edge in self.edges]
            self.solve()

    def measure(self) -> dict[int, Uncertainty]:
        """How well the poses are known that nothing leaves open."""
        solution = self.solution
        T_0 = {view: T for view, T in solution.T_0.items() if view in solution.rigid}
        holding = [edge for edge, keep in zip(self.edges, solution.kept, strict=True) if keep and _holds(edge, T_0)]
        return _measure(holding, T_0, self.cache, self.origin)

    def _register(self, source: int, target: int, start: np.ndarray | None) -> PairEstimate:
        usual = UsualMisfit.of([edge for edge in self.edges if edge.status == Status.OK])
        return self.judge(self.register(self.cache.get(source), self.cache.get(target), Hints(start, usual)))

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


def reconsider(
    found: MethodResult, symmetries: Sequence[Symmetry], origin: int | None, cache: ViewCache, settings: PairSettings
) -> MethodResult:
    """Return a method's result after what the whole session tells was looked for in each of its pairs.

    That is the object's symmetries, in frame {0}, and whether the pairs bear the user's step out.
    """
    T_0 = {view.view: view.T_0_i for view in found.views}
    pairs = []
    for pair in found.pairs:
        if (T := T_0.get(pair.target)) is not None and pair.status.is_believed:
            both = PairRegistration(cache.get_surface(pair.source), cache.get_surface(pair.target), settings)
            pair = challenge(both, pair, [symmetry.moved(poses.invert(T)) for symmetry in symmetries])
        pairs.append(pair)
    if is_refuted(pairs):
        pairs = [distrust(pair) for pair in pairs]
    own = {pair.source: pair for pair in pairs}
    connected: set[int | None] = {origin}
    views: list[ViewEstimate] = []
    for view in found.views:
        status = view.status
        if (placed_by := own.get(view.view)) is not None and status.is_believed:
            hangs = placed_by.status == Status.OK and placed_by.target not in connected
            status = Status.NOT_CONNECTED if hangs else placed_by.status
        if status == Status.OK:
            connected.add(view.view)
        views.append(replace(view, status=status))
    if origin is not None:
        holding = [pair for pair in pairs if pair.status == Status.OK and {pair.source, pair.target} <= connected]
        poses_ok = {view.view: view.T_0_i for view in views if view.status == Status.OK and view.T_0_i is not None}
        bounds, diameter = _measure(holding, poses_ok, cache, origin), cache.get_surface(origin).scale.diameter
        views = [_bounded(view, bounds.get(view.view), origin, diameter) for view in views]
        views = refuse_stillness(views, origin, cache)
    return MethodResult.of(views, pairs, origin, symmetries=tuple(symmetries))


def refuse_stillness(views: Sequence[ViewEstimate], origin: int, cache: ViewCache) -> list[ViewEstimate]:
    """Return the views, `inconsistent` where none moves: what was registered may be what stands still."""
    placed = {v.view: v.T_0_i for v in views if v.view != origin and v.status == Status.OK and v.T_0_i is not None}
    for view, T_0_i in placed.items():
        prepared = cache.get_surface(view)
        center = prepared.surface.surfels.points.mean(axis=0)
        shift = float(np.linalg.norm(poses.transform(T_0_i, center[None])[0] - center))
        turn = np.degrees(poses.rotation_angle(T_0_i[:3, :3]))
        if turn > _STILL_DEG or shift > _STILL_SHARE * prepared.scale.diameter:
            return list(views)
    return [replace(v, status=Status.INCONSISTENT, note=STILL) if v.view in placed else v for v in views]


def _measure(
    pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray], cache: ViewCache, origin: int
) -> dict[int, Uncertainty]:
    """How well the poses are known that pairs hold, about the centre of each view's points."""
    means = {view: cache.get_surface(view).surface.surfels.points.mean(axis=0) for view in T_0}
    centers = {view: poses.transform(T_0[view], mean[None])[0] for view, mean in means.items()}
    return measure_graph(pairs, T_0, centers, origin)


def _bounded(view: ViewEstimate, known: Uncertainty | None, origin: int, diameter: float) -> ViewEstimate:
    """An ok view with its bounds; `ambiguous` where these allow it to be wrong."""
    if view.view == origin:
        return replace(view, rotation_bound_deg=0.0, center_bound_m=0.0)
    if known is None or view.status != Status.OK:
        return view
    status = Status.OK if known.is_good(diameter) else Status.AMBIGUOUS
    bounds = known.rotation_bound_deg, known.center_bound_m
    return replace(view, status=status, rotation_bound_deg=bounds[0], center_bound_m=bounds[1])


def _is_edge(pair: PairEstimate) -> bool:
    """Whether a pair holds two views together: it is right, or right but for what the views leave open."""
    return pair.status.is_believed and pair.information is not None


def _holds(edge: PairEstimate, T_0: Mapping[int, np.ndarray]) -> bool:
    """Whether an edge leaves nothing open between two of the placed views."""
    return edge.status == Status.OK and edge.source in T_0 and edge.target in T_0


def _estimate(
    view: ViewEstimate, solution: Solution, bounds: Mapping[int, Uncertainty], origin: int, diameter: float
) -> ViewEstimate:
    """Return a view as the solution places it."""
    T_0_i = solution.T_0.get(view.view)
    if T_0_i is None:
        lost = view.status if view.status in (Status.UNREADABLE, Status.TOO_FEW_POINTS) else Status.NOT_CONNECTED
        return ViewEstimate(view.view, lost, None)
    rigid = view.view == origin or view.view in bounds
    placed = ViewEstimate(view.view, Status.OK if rigid else Status.AMBIGUOUS, T_0_i)
    return _bounded(placed, bounds.get(view.view), origin, diameter)


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
