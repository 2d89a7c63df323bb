"""The words in which results speak: methods, and what becomes of a view or a pair; with meaning, colour and rank."""

from collections.abc import Iterable
from enum import StrEnum
from typing import Self

Color = tuple[int, int, int]

_GOOD: Color = (0, 160, 112)
_FREE: Color = (240, 228, 66)
_BAD: Color = (240, 90, 40)


class Method(StrEnum):
    """How views are registered, worst to best. Colours after Okabe and Ito: the colour-blind tell them apart."""

    color: Color  # a contrast of 3:1 on white, on black, on the 3D background

    def __new__(cls, value: str, color: Color) -> Self:
        """A method by its name in results, and the colour of its curves and frusta."""
        member = str.__new__(cls, value)
        member._value_, member.color = value, color
        return member

    __repr__ = str.__repr__  # printed as results.json has it

    ICP = "icp", (208, 128, 0)
    RANSAC_ICP = "ransac_icp", (70, 140, 225)
    PAIRWISE = "pairwise", (0, 160, 112)
    REFINED = "refined", (204, 121, 167)


METHODS = tuple(Method)  # worst to best: the model is made by the last one run


def best_method(run: Iterable[str]) -> Method | None:
    """The best of the methods that were run; None where there are none."""
    chosen = set(run)
    return next((method for method in reversed(METHODS) if method in chosen), None)


class Status(StrEnum):
    """What becomes of a view or a pair: `ok` claims that the pose is right, all else says why it does not."""

    meaning: str
    color: Color
    rank: int  # 2: right; 1: right but for what the views cannot tell; 0: failed

    def __new__(cls, value: str, meaning: str, color: Color = _BAD, rank: int = 0) -> Self:
        """A status by its name in results."""
        member = str.__new__(cls, value)
        member._value_, member.meaning, member.color, member.rank = value, meaning, color, rank
        return member

    __repr__ = str.__repr__  # printed as results.json has it

    OK = "ok", "the pose is right", _GOOD, 2
    AMBIGUOUS = (
        "ambiguous",
        "several poses explain it equally well, or a motion of it changes nothing that the views show",
        _FREE,
        1,
    )
    LOW_OVERLAP = "low_overlap", "too little of the surface lies on the earlier view"
    DIVERGED = "diverged", "the surfaces that should overlap lie apart"
    INCONSISTENT = "inconsistent", "a surface would be seen through another"
    NO_CONSENSUS = "no_consensus", "no motion explains enough of the matches"
    TOO_FEW_MATCHES = "too_few_matches", "too few descriptors match"
    TOO_FEW_KEYPOINTS = "too_few_keypoints", "too little structure for keypoints"
    TOO_FEW_POINTS = "too_few_points", "too few points to register"
    NOT_CONNECTED = (
        "not_connected",
        "its own pair may be right, but no pairs that are lead from it to the first view",
    )
    UNREADABLE = "unreadable", "its recorded cloud is damaged"

    @property
    def is_believed(self) -> bool:
        """Whether geometry bears the pose out, though not always it alone."""
        return self.rank > 0


# An ok view is wrong where it is off the truth by more degrees, or its centre by more than this share of the diameter.
WRONG_DEG, WRONG_SHARE = 5.0, 0.05
