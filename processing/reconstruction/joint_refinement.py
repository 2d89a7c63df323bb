"""The joint refinement: edges between all views that overlap, found and not assumed, and one pose for each view."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise as successive

import numpy as np

from orbitscan.processing.reconstruction.components import label_groups, place_views
from orbitscan.processing.reconstruction.partners import (
    Partners,
    choose_edges,
    choose_keyviews,
    choose_nearest,
    viewing_direction,
)
from orbitscan.processing.reconstruction.pose_graph import GraphSettings, Solution, solve
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
    pairwise: MethodResult, cache: ViewCache, register: Register, pair_settings: PairSettings, settings: GraphSettings
) -> MethodResult:
    """Refine all views of a session together, starting from the pairs of successive views.

    What these do not hold to the most views is registered to some of them. Then keyviews, spread over all, are
    registered to those that they should overlap, and the views between them aligned to the nearest; the graph is
    solved. What all views together tell of the object's symmetries is looked for in every edge. {0} is the first of the
    most views that edges hold together which leave nothing open: these are `ok`, `ambiguous` those that others lead to,
    `not_connected` the rest.
    """
    views = [v.view for v in pairwise.views if v.status not in (Status.UNREADABLE, Status.TOO_FEW_POINTS)]
    if not views:
        return MethodResult.of(pairwise.views, (), None)
    graph = _Graph(views, cache, register, pair_settings, settings, cache.get_surface(views[0]).scale.diameter)
    graph.refuted_step = is_refuted(pairwise.pairs)
    graph.edges = [pair for pair in map(graph.judge, pairwise.pairs) if _is_edge(pair)]
    graph.solve()
    graph.attach(pairwise.pairs)
    graph.close()
    graph.solve()
    graph.register_with_itself()
    solution, edges = graph.solution, graph.edges
    kept = [edge for edge, keep in zip(edges, solution.kept, strict=True) if keep]
    left_out = [edge for edge, keep in zip(edges, solution.kept, strict=True) if not keep]
    contradicting = [edge for edge in (*left_out, *graph.refuted) if edge.status == Status.OK]
    placed = _place(pairwise.views, solution)
    judged = judge_views(placed, kept, solution.origin, graph.diameter, contradicting)
    shown = [_mark(edge, keep) for edge, keep in zip(edges, solution.kept, strict=True)]
    shown += [_mark(edge, keep=False) for edge in graph.refuted]
    freedoms = _find_freedoms(solution, edges, graph.diameter, settings)
    return MethodResult.of(
        judged,
        bound_centers(shown, judged),
        solution.origin,
        loop_closed=_goes_round(solution, edges, [v.view for v in pairwise.views]),
        freedoms=freedoms,
        symmetries=tuple(s for s in graph.symmetries if not is_turn(freedoms, s, graph.diameter)),
    )


@dataclass
class _Graph:
    """The edges found so far, what they tell together, and what more of them are found with."""

    views: Sequence[int]  # that can be registered, in the order of use
    cache: ViewCache
    register: Register
    pair_settings: PairSettings
    settings: GraphSettings
    diameter: float  # of the object [m]
    edges: list[PairEstimate] = field(default_factory=list)
    symmetries: list[Symmetry] = field(default_factory=list)  # of the object, in frame {0}
    refuted: list[PairEstimate] = field(default_factory=list)  # that seem right, but for what the others say
    refuted_step: bool = False  # whether the pairs decide against the user's step
    solution: Solution = field(default_factory=lambda: Solution((), ()))

    def judge(self, pair: PairEstimate) -> PairEstimate:
        """A pair, after what the others say of the user's step."""
        return distrust(pair) if self.refuted_step else pair

    def solve(self, before: Collection[int] = ()) -> None:
        """Solve the graph of the edges found so far; what holds the views `before` gives frame {0}."""
        self.solution = solve(self.edges, self.views, self.diameter, self.settings, before)

    def attach(self, known: Sequence[PairEstimate]) -> None:
        """Find edges that hold what is apart to the most views that hold together, until no more can be.

        Where the views nearly slide, as mugs with hidden handles do, only a neighbour in time vouches for such an edge.
        """
        partners = Partners(self.views, self.cache, self.pair_settings, self.settings, self.diameter)
        for pair in known:
            partners.learn(pair)
        while (edge := self._find_edge(partners)) is not None:
            self.edges.append(edge)
            self.solve()

    def _find_edge(self, partners: Partners) -> PairEstimate | None:
        """Find one edge that holds views which are apart to those that hold together."""
        core = self.solution.rigid
        apart = [group for group in self._list_groups() if core.isdisjoint(group)]
        for source, target in partners.propose(apart, [view for view in self.views if view in core]):
            edge = self._register(source, target, {})
            partners.learn(edge)
            near = abs(source - target) <= self.settings.vouching
            if edge.status == Status.OK and (near or self._holds(edge)):
                return edge
        return None

    def _list_groups(self) -> list[list[int]]:
        """List the views that edges hold together which leave nothing open, each group in the order of use."""
        kept = [edge for edge, keep in zip(self.edges, self.solution.kept, strict=True) if keep]
        ends = [edge.ends for edge in kept if edge.status == Status.OK]
        groups: dict[int, list[int]] = {}
        for view, label in zip(self.views, label_groups(self.views, ends).tolist(), strict=True):
            groups.setdefault(label, []).append(view)
        return list(groups.values())

    def close(self) -> None:
        """Find edges between views that should overlap by their poses, which are one of many starts for keyviews."""
        rigid = {view: T for view, T in self.solution.T_0.items() if view in self.solution.rigid}
        outlooks = {view: self.cache.get_outlook(view) for view in rigid}
        directions = {v: viewing_direction(rigid[v], seen.middle, seen.sensor_origin) for v, seen in outlooks.items()}
        keyviews = choose_keyviews(directions, self.settings.keyview_deg)
        known = [edge.ends for edge in self.edges]
        edges = choose_edges({view: directions[view] for view in keyviews}, known, self.settings.bands_deg)
        for source, target in edges + choose_nearest(directions, keyviews, known):
            start = poses.invert(rigid[target]) @ rigid[source]
            between = source not in keyviews
            edge = self._register(source, target, {"graph": start}, alone=between)
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
            self.solve(before=T_0.keys())  # what is apart was not looked at: it is not to be believed instead
            back = poses.invert(T_0[self.solution.origin])  # another view may be the first that nothing is open of
            self.symmetries = [symmetry.moved(back) for symmetry in self.symmetries]

    def _register(
        self, source: int, target: int, starts: Mapping[str, np.ndarray], *, alone: bool = False
    ) -> PairEstimate:
        usual = UsualMisfit.of([edge for edge in self.edges if edge.status == Status.OK])
        get = self.cache.get_surface if alone else self.cache.get
        return self.judge(self.register(get(source), get(target), Hints(starts, usual, only_ok=True, alone=alone)))

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


def _place(views: Sequence[ViewEstimate], solution: Solution) -> list[ViewEstimate]:
    """Return views as the solution places them."""
    before = {view.view: view for view in views}
    held = {view for component in solution.components if len(component.T) > 1 for view in component.T}

    def tell(view: int) -> tuple[Status, str | None]:
        told, note = before[view].status, before[view].note
        if view in held or view == solution.origin:
            return Status.AMBIGUOUS, None
        if told == Status.INCONSISTENT and note is not None:
            return told, note
        return told if told in (Status.UNREADABLE, Status.TOO_FEW_POINTS) else Status.NOT_CONNECTED, None

    return place_views(views, solution.components, tell)


def _mark(edge: PairEstimate, keep: bool) -> PairEstimate:
    """Return an edge as it is, or as one that the others contradict."""
    return edge if keep else replace(edge, status=Status.INCONSISTENT)


def _goes_round(solution: Solution, edges: Sequence[PairEstimate], views: Sequence[int]) -> bool:
    """Whether an edge joins two views between which the views on the way turn all the way round."""
    placed = [view for view in views if view in solution.T_0]
    turns = [poses.rotation_angle(solution.T_0[a][:3, :3].T @ solution.T_0[b][:3, :3]) for a, b in successive(placed)]
    turned = dict(zip(placed, np.concatenate([[0.0], np.cumsum(turns)]), strict=True))
    kept = [e for e, keep in zip(edges, solution.kept, strict=True) if keep]
    ends = [e.ends for e in kept if e.source in turned and e.target in turned]
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
            moved = freedom.moved(T)
            if not any(same_freedom(moved, other, *near) for other in found):
                found.append(moved)
    return tuple(found)
