"""The poses of one method, composed pair by pair (thesis (4.17))."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.results.estimates import MethodResult, PairEstimate, UsualMisfit, ViewEstimate
from orbitscan.processing.results.status import Method, Status

_STREAMED = (
    Method.ICP,
    Method.RANSAC_ICP,
    Method.PAIRWISE,
)  # place a view when it comes; `refined` begins where `pairwise` ends
_NEAR = 1  # views back at which the last connected one is still worth trying: one bad view costs one view


@dataclass(frozen=True, eq=False)
class Placed:
    """A view with a pose, that others can be registered to."""

    prepared: PreparedView
    T_0_i: np.ndarray
    connected: bool  # whether pairs that are all ok lead from it to the origin
    place: int = 0  # in the sequence of views


@dataclass(frozen=True, eq=False)
class Hints:
    """What the pairs before tell a registration."""

    starts: Mapping[str, np.ndarray] = field(default_factory=dict)  # likely poses T_target_source, by their names
    usual: UsualMisfit | None = None  # of pairs that are right
    only_ok: bool = False  # whether a pair is of no use that leaves anything open


@dataclass
class Trajectory:
    """Where a method has placed the views so far, in the frame {0} of the first one with points enough."""

    retries: bool = False  # whether a view is tried on the last connected view before the last one
    views: list[ViewEstimate] = field(default_factory=list)
    pairs: list[PairEstimate] = field(default_factory=list)
    last: Placed | None = None  # the last view that has a pose
    anchor: Placed | None = None  # the last one that is connected
    step: np.ndarray | None = None  # the motion of the last pair, where it is right: T_target_source

    @property
    def targets(self) -> list[Placed]:
        """The views that the next one is registered to, in order, until a pair is ok."""
        tried = [self.last]
        if self.retries and self.anchor and self.last and self.last.place - self.anchor.place <= _NEAR:
            tried = [self.anchor, self.last]
        return list(dict.fromkeys(target for target in tried if target is not None))

    @property
    def hints(self) -> Hints:
        """What is known of the next view's registration."""
        usual = UsualMisfit.of([pair for pair in self.pairs if pair.status == Status.OK])
        return Hints({} if self.step is None else {"previous": self.step}, usual)

    def start(self, prepared: PreparedView) -> ViewEstimate:
        """Make a view the origin: T_0_0 = I."""
        return self._add(prepared, Status.OK, np.eye(4))

    def attach(self, register: Callable[[PreparedView, Hints], PairEstimate]) -> tuple[PairEstimate, Placed]:
        """Return the pair of the next view with the first of its targets that it fits, else with the likeliest."""
        attempts = []
        for target in self.targets:
            pair = register(target.prepared, self.hints)
            attempts.append((pair, target))
            if pair.status == Status.OK:
                break
        return max(reversed(attempts), key=lambda attempt: (attempt[0].status.rank, attempt[0].confidence))

    def extend(self, prepared: PreparedView, pair: PairEstimate, target: Placed) -> ViewEstimate:
        """Place a view by its pair: T_0_i = T_0_target T_target_i; without an estimate it has no pose.

        The view's status is the pair's; `not_connected` where the pair is ok but hangs on one that is not.
        """
        self.pairs.append(pair)
        self.step = pair.T_target_source if pair.status == Status.OK else None
        if pair.T_target_source is None:
            return self.skip(pair.source, pair.status)
        status = pair.status if pair.status != Status.OK or target.connected else Status.NOT_CONNECTED
        return self._add(prepared, status, target.T_0_i @ pair.T_target_source, pair.note)

    def skip(self, view: int, status: Status) -> ViewEstimate:
        """Leave a view without a pose."""
        self.views.append(ViewEstimate(view, status, None))
        return self.views[-1]

    def result(self, origin: int | None) -> MethodResult:
        """Return all views and pairs, as a record."""
        return MethodResult.of(self.views, self.pairs, origin)

    def _add(self, prepared: PreparedView, status: Status, T_0_i: np.ndarray, note: str | None = None) -> ViewEstimate:
        self.last = Placed(prepared, T_0_i, status == Status.OK, len(self.views))
        if self.last.connected:
            self.anchor = self.last
        self.views.append(ViewEstimate(prepared.surface.view, status, T_0_i, note=note))
        return self.views[-1]


def begin_trajectories(methods: Sequence[str]) -> dict[Method, Trajectory]:
    """Return an empty trajectory for each method that places views one after the other, by method, worst to best."""
    wanted = {Method.PAIRWISE if method == Method.REFINED else method for method in methods}
    return {method: Trajectory(retries=method == Method.PAIRWISE) for method in _STREAMED if method in wanted}
