"""The words in which results speak: methods, and what becomes of a view or a pair; with meaning, colour and rank."""

from collections.abc import Iterable
from enum import StrEnum
from typing import NamedTuple

from orbitscan.processing.results import colors
from orbitscan.processing.results.colors import Color


class Method(StrEnum):
    """How views are registered, worst to best."""

    __repr__ = str.__repr__  # printed as results.json has it

    ICP = "icp"
    RANSAC_ICP = "ransac_icp"
    PAIRWISE = "pairwise"
    REFINED = "refined"

    @property
    def color(self) -> Color:
        """The colour of its curves and frusta."""
        return _METHOD_COLORS[self]


_METHOD_COLORS = {
    Method.ICP: colors.ICP,
    Method.RANSAC_ICP: colors.RANSAC_ICP,
    Method.PAIRWISE: colors.PAIRWISE,
    Method.REFINED: colors.REFINED,
}
METHODS = tuple(Method)  # worst to best: the model is made by the last one run


def best_method(run: Iterable[str]) -> Method | None:
    """The best of the methods that were run; None where there are none."""
    chosen = set(run)
    return next((method for method in reversed(METHODS) if method in chosen), None)


class Status(StrEnum):
    """What becomes of a view or a pair: `ok` claims that the pose is right, all else says why it does not."""

    __repr__ = str.__repr__  # printed as results.json has it

    OK = "ok"
    AMBIGUOUS = "ambiguous"
    LOW_OVERLAP = "low_overlap"
    DIVERGED = "diverged"
    INCONSISTENT = "inconsistent"
    NO_CONSENSUS = "no_consensus"
    TOO_FEW_MATCHES = "too_few_matches"
    TOO_FEW_KEYPOINTS = "too_few_keypoints"
    TOO_FEW_POINTS = "too_few_points"
    NOT_CONNECTED = "not_connected"
    UNREADABLE = "unreadable"

    @property
    def meaning(self) -> str:
        """The status in words."""
        return _STATUSES[self].meaning

    @property
    def color(self) -> Color:
        """The colour of what has it."""
        return _STATUSES[self].color

    @property
    def rank(self) -> int:
        """2 where the pose is right, 1 where it is but for what the views cannot tell, 0 where it failed."""
        return _STATUSES[self].rank

    @property
    def is_believed(self) -> bool:
        """Whether geometry bears the pose out, though not always it alone."""
        return self.rank > 0


class _Row(NamedTuple):
    meaning: str
    color: Color = colors.BAD
    rank: int = 0


_STATUSES = {
    Status.OK: _Row("the pose is right", colors.GOOD, 2),
    Status.AMBIGUOUS: _Row(
        "several poses explain it equally well, a motion of it changes nothing that the views show, or it is known too "
        "badly to be called right",
        colors.FREE,
        1,
    ),
    Status.LOW_OVERLAP: _Row("too little of the surface lies on the earlier view"),
    Status.DIVERGED: _Row("the surfaces that should overlap lie apart"),
    Status.INCONSISTENT: _Row("a surface would be seen through another"),
    Status.NO_CONSENSUS: _Row("no motion explains enough of the matches"),
    Status.TOO_FEW_MATCHES: _Row("too few descriptors match"),
    Status.TOO_FEW_KEYPOINTS: _Row("too little structure for keypoints"),
    Status.TOO_FEW_POINTS: _Row("too few points to register"),
    Status.NOT_CONNECTED: _Row("its own pair may be right, but no pairs that are lead from it to view {0}"),
    Status.UNREADABLE: _Row("its recorded cloud is damaged"),
}

# An ok view is wrong where it is off the truth by more degrees, or its centre by more than this share of the diameter.
WRONG_DEG, WRONG_SHARE = 5.0, 0.05
