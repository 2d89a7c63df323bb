"""A study as its recording shows it, and where in the recording its parts are."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import rerun as rr

from orbitscan.processing.review.study_curves import Curve, find_curves
from orbitscan.processing.review.verdicts import Statement

Cloud = tuple[np.ndarray, np.ndarray | None]  # points (N, 3), z up; colours (N, 3) uint8


@dataclass(frozen=True, eq=False)
class StudyReview:
    """A study as it is shown."""

    report: Mapping[str, Any]  # its JSON
    figures: Mapping[str, bytes] = field(default_factory=dict)  # PNG, by name
    frames: Sequence[Mapping[str, Any]] = ()  # rows whose curves are shown; none: the report's
    models: Mapping[str, Mapping[str, Cloud]] = field(default_factory=dict)  # by object, then by method

    @property
    def name(self) -> str:
        """As the command names it."""
        return self.report["name"]

    @property
    def origin(self) -> str:
        """The entity that all of it is below."""
        return entity_path("studies", self.name)

    @property
    def curves(self) -> list[Curve]:
        """Of its frames or else its rows."""
        return find_curves(self.frames or self.report["rows"])

    def figure_path(self, name: str) -> str:
        """The entity of a figure."""
        return entity_path("studies", self.name, "figures", name)

    def model_path(self, thing: str, method: str) -> str:
        """The entity of a model."""
        return entity_path("studies", self.name, "models", thing, method)

    def plot_path(self, plot: str, quantity: str) -> str:
        """The entity that the lines of a plot are below, as they are named."""
        return entity_path("studies", self.name, "curves", plot or "all", quantity)


def entity_path(*parts: str) -> str:
    """An entity by its parts, which may hold any sign."""
    return "/" + "/".join(map(rr.escape_entity_path_part, parts))


def collect_verdicts(studies: Sequence[StudyReview]) -> dict[str, list[str]]:
    """The verdicts of each study that has any, by name."""
    found = {s.name: [Statement.read(sentence).verdict for sentence in s.report["said"]] for s in studies}
    return {name: told for name, verdicts in found.items() if (told := [v for v in verdicts if v])}
