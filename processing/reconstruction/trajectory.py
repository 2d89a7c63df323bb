"""The poses of one method, composed pair by pair (thesis (4.17))."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from orbitscan.processing.reconstruction.components import find_components, place_views
from orbitscan.processing.reconstruction.pose_graph import place
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.results.estimates import MethodResult, PairEstimate, UsualMisfit, ViewEstimate
from orbitscan.processing.results.status import Method, Status

_STREAMED = (
    Method.ICP,
    Method.RANSAC_ICP,
    Method.PAIRWISE,
)  # place a view when it comes; `refined` begins where `pairwise` ends
_NEAR = 1  # views back at which the last connected one is still worth trying: one bad view costs one view
_EARLIER = 2  # views before those, for one that fits none of them


@dataclass(frozen=True, eq=False)
class Placed:
    """A view with a pose, that others can be registered to."""

    prepared: PreparedView
    T: np.ndarray  # (4, 4), in the frame of its component's first view
    connected: bool  # whether pairs that are all ok lead from it to the origin
    place: int = 0  # in the sequence of views
    component: int = 0  # those after the first begin with a view that fits none before it


@dataclass(frozen=True, eq=False)
class Hints:
    """What the pairs before tell a registration."""

    starts: Mapping[str, np.ndarray] = field(default_factory=dict)  # likely poses T_target_source, by their names
    usual: UsualMisfit | None = None  # of pairs that are right
    only_ok: bool = False  # whether a pair is of no use that leaves anything open
    alone: bool = False  # whether the likely poses are all that is tried, as others were on the way there


@dataclass
class Trajectory:
    """Where a method has placed the views so far, in the frame {0} of the first one with points enough.

    The thesis's methods go on from any pose. A method that `doubts` does not from one that geometry does not bear out:
    it tries the view on earlier ones, and the next ones on it, which then hold together but to nothing before them.
    """

    doubts: bool = False
    views: list[ViewEstimate] = field(default_factory=list)
    pairs: list[PairEstimate] = field(default_factory=list)
    placed: list[Placed] = field(default_factory=list)  # the last ones that have a pose
    anchor: Placed | None = None  # the last one that is connected
    step: np.ndarray | None = None  # the motion of the last pair, where it is right: T_target_source
    components: int = 0

    @property
    def last(self) -> Placed | None:
        """The last view that has a pose."""
        return self.placed[-1] if self.placed else None

    @property
    def targets(self) -> list[Placed]:
        """The views that the next one is registered to, in order, until a pair is ok."""
        likely = [self.last]
        if self.doubts and self.anchor and self.last and self.last.place - self.anchor.place <= _NEAR:
            likely = [self.anchor, self.last]
        return list(dict.fromkeys(target for target in likely if target is not None))

    @property
    def earlier(self) -> list[Placed]:
        """Those that it is registered to where geometry bears none of these pairs out."""
        return [view for view in reversed(self.placed) if view not in self.targets][:_EARLIER] if self.doubts else []

    @property
    def hints(self) -> Hints:
        """What is known of the next view's registration."""
        usual = UsualMisfit.of([pair for pair in self.pairs if pair.status == Status.OK])
        return Hints({} if self.step is None else {"previous": self.step}, usual)

    def start(self, prepared: PreparedView) -> ViewEstimate:
        """Make a view the origin: T_0_0 = I."""
        return self._add(prepared, Status.OK, np.eye(4), 0)

    def attach(self, register: Callable[[PreparedView, Hints], PairEstimate]) -> tuple[PairEstimate, Placed]:
        """Return the pair of the next view with the first of its targets that it fits, else with the likeliest."""
        attempts: list[tuple[PairEstimate, Placed]] = []
        for targets in (self.targets, self.earlier):
            for target in targets:
                attempts.append((register(target.prepared, self.hints), target))
                if attempts[-1][0].status == Status.OK:
                    break
            if any(pair.status.is_believed for pair, _ in attempts):
                break
        return max(reversed(attempts), key=lambda attempt: (attempt[0].status.rank, attempt[0].confidence))

    def extend(self, prepared: PreparedView, pair: PairEstimate, target: Placed) -> ViewEstimate:
        """Place a view by its pair: T_0_i = T_0_target T_target_i (4.17); without an estimate it has no pose.

        The view's status is the pair's; `not_connected` where the pair is ok but hangs on one that is not.
        """
        self.pairs.append(pair)
        self.step = pair.T_target_source if pair.status == Status.OK else None
        if pair.T_target_source is None and not self.doubts:
            return self.skip(pair.source, pair.status)
        if pair.T_target_source is None or (self.doubts and not pair.status.is_believed):
            self.components += 1
            return self._add(prepared, pair.status, np.eye(4), self.components, pair.note, alone=True)
        status = pair.status if pair.status != Status.OK or target.connected else Status.NOT_CONNECTED
        return self._add(prepared, status, target.T @ pair.T_target_source, target.component, pair.note)

    def skip(self, view: int, status: Status) -> ViewEstimate:
        """Leave a view without a pose."""
        self.views.append(ViewEstimate(view, status, None))
        return self.views[-1]

    def result(self, origin: int | None = None) -> MethodResult:
        """Return all views and pairs, as a record, in the frame of an origin (see `compose`)."""
        first = next((view.view for view in self.views if view.component == 0), None)
        if origin is None and not self.doubts:
            origin = first
        links = [pair for pair in self.pairs if pair.status.is_believed or not self.doubts]
        views = self.views if first is None else compose(self.views, self.pairs, links, origin)
        return MethodResult.of(views, self.pairs, origin)

    def _add(
        self,
        prepared: PreparedView,
        status: Status,
        T: np.ndarray,
        component: int,
        note: str | None = None,
        *,
        alone: bool = False,
    ) -> ViewEstimate:
        view, connected = prepared.surface.view, status == Status.OK and component == 0
        self.placed.append(Placed(prepared, T, connected, len(self.views), component))
        del self.placed[: -2 - _EARLIER]
        if connected:
            self.anchor = self.last
        if component == 0:
            found = ViewEstimate(view, status, T, note=note, component=0)
        else:
            held = None if alone else component
            found = ViewEstimate(view, status, None, note=note, component=held, T_component_i=T)
        self.views.append(found)
        return found


def compose(
    views: Sequence[ViewEstimate], pairs: Sequence[PairEstimate], links: Sequence[PairEstimate], origin: int | None
) -> list[ViewEstimate]:
    """Place views along those pairs that link them, at most one from each view to an earlier one.

    {0} is the origin's frame, else that of the first view of the most that ok pairs hold together. A view's status is
    its own pair's; `not_connected` where that is ok but no ok pairs lead from it to the origin.
    """
    own = {pair.source: pair for pair in pairs}
    unusable = {view.view: view.status for view in views if view.status in (Status.UNREADABLE, Status.TOO_FEW_POINTS)}

    def tell(view: int) -> tuple[Status, str | None]:
        pair = own.get(view)
        if view in unusable or pair is None or pair.status == Status.OK:
            return unusable.get(view, Status.NOT_CONNECTED), None
        return pair.status, pair.note

    holding = [pair for pair in links if pair.T_target_source is not None]
    found, _ = place(holding, [0] * len(holding))
    T = {view.view: found.get(view.view, np.eye(4)) for view in views if view.view not in unusable}
    rigid = [pair for pair in holding if pair.status == Status.OK]
    components = find_components(T, [pair.ends for pair in holding], [pair.ends for pair in rigid], origin)
    return place_views(views, components, tell, {pair.source: pair.note for pair in rigid})


def begin_trajectories(methods: Sequence[str]) -> dict[Method, Trajectory]:
    """Return an empty trajectory for each method that places views one after the other, by method, worst to best."""
    wanted = {Method.PAIRWISE if method == Method.REFINED else method for method in methods}
    return {method: Trajectory(doubts=method == Method.PAIRWISE) for method in _STREAMED if method in wanted}
