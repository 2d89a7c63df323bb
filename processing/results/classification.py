"""What a view alone shows, and the views of a session together."""

from collections.abc import Mapping
from dataclasses import dataclass

UNKNOWN = "unknown"  # what a model does not know, in place of a category


@dataclass(frozen=True)
class ViewClassification:
    """What one view shows; probabilities are among the model's categories, as if it were one of them."""

    view: int  # recorded index
    category: str | None  # None exactly when `known` is false
    likeliest: str  # the most probable category all the same
    known: bool  # whether the model knows such a thing at all
    score: float  # of being known: the free energy of the logits of shape and size
    probabilities: Mapping[str, float]
    orientation: tuple[int, float] | None = None  # the run of the circle that is seen, and its probability

    @property
    def answer(self) -> str:
        """The category, or UNKNOWN."""
        return self.category or UNKNOWN


@dataclass(frozen=True)
class SessionClassification:
    """What the views of a session show together, and each alone."""

    model: str  # SHA-256 of its file
    categories: tuple[str, ...]
    category: str | None  # None exactly when `known` is false
    likeliest: str
    known: bool
    probability: float  # of the likeliest, fused over all views
    fused: tuple[Mapping[str, float], ...]  # probabilities after each view
    entropy: tuple[float, ...]  # of them, in nats
    views: tuple[ViewClassification, ...]

    @property
    def answer(self) -> str:
        """The category, or UNKNOWN."""
        return self.category or UNKNOWN
