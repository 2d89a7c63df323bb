"""A study as its recording shows it: where its parts are, and the curves that are in its rows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from orbitscan.processing.reproduction.claims import Claim
from orbitscan.processing.reproduction.index.columns import THESIS, is_number
from orbitscan.processing.reproduction.report import SavedReport
from orbitscan.processing.review.entities import entity_path

Cloud = tuple[np.ndarray, np.ndarray | None]  # points (N, 3), z up; colours (N, 3) uint8
TIMELINES = {"step": "", "view": "error"}  # columns that count -> what is in the names of the quantities over them
_STATUS = "status"  # is no label: it changes along a curve
_LINES = "method"  # the label that tells lines apart, where a study has several; else the last


@dataclass(frozen=True)
class Curve:
    """A quantity over steps of a training or over views."""

    plot: str  # of which it is a line: an object's name; '' where all lines are in one plot
    quantity: str  # as the column is named, with its unit
    line: str
    timeline: str  # one of TIMELINES
    times: tuple[int, ...]
    values: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class StudyReview:
    """A study with what its recording shows of it."""

    report: SavedReport
    figures: Mapping[str, bytes] = field(default_factory=dict)  # PNG, by name
    frames: Sequence[Mapping[str, Any]] = ()  # rows whose curves are shown; none: the report's
    models: Mapping[str, Mapping[str, Cloud]] = field(default_factory=dict)  # by object, then by method

    @property
    def name(self) -> str:
        """The study's name, as the command has it."""
        return self.report.name

    @property
    def origin(self) -> str:
        """The entity below which all of the study is logged."""
        return entity_path("studies", self.name)

    @property
    def curves(self) -> list[Curve]:
        """The curves of its frames, or else of its rows."""
        return find_curves(self.frames or self.report.rows)

    def figure_path(self, name: str) -> str:
        """The entity of a figure, by its name."""
        return entity_path("studies", self.name, "figures", name)

    def model_path(self, thing: str, method: str) -> str:
        """The entity of the model of a thing by a method."""
        return entity_path("studies", self.name, "models", thing, method)

    def plot_path(self, plot: str, quantity: str) -> str:
        """The entity below which the lines of a plot are logged, each by its name."""
        return entity_path("studies", self.name, "curves", plot or "all", quantity)


def collect_claims(studies: Sequence[StudyReview]) -> dict[str, list[Claim]]:
    """The claims of each study that has any, by the study's name."""
    return {study.name: study.report.claims for study in studies if study.report.claims}


def find_timeline(rows: Sequence[Mapping[str, Any]]) -> str | None:
    """The column that counts steps or views; None where no quantity changes along one."""
    return next((name for name in TIMELINES if rows and name in rows[0] and _name_quantities(rows, name)), None)


def find_curves(rows: Sequence[Mapping[str, Any]]) -> list[Curve]:
    """A curve for each quantity and label of the rows; numbers that are not known are left out."""
    timeline = find_timeline(rows)
    if timeline is None:
        return []
    quantities = _name_quantities(rows, timeline)
    labels = [name for name, value in rows[0].items() if isinstance(value, str) and name != _STATUS]
    line_label = _LINES if _LINES in labels else labels[-1] if labels else None
    found: dict[tuple[str, str, str], dict[int, float]] = {}
    for row in rows:
        plot = ", ".join(str(row[name]) for name in labels if name != line_label)
        line = str(row[line_label]) if line_label else ""
        for name in quantities:
            if is_number(row[name]):
                found.setdefault((plot, name, line), {})[row[timeline]] = row[name]
    return [
        Curve(*key, timeline, tuple(sorted(points)), tuple(points[time] for time in sorted(points)))
        for key, points in found.items()
    ]


def _name_quantities(rows: Sequence[Mapping[str, Any]], timeline: str) -> list[str]:
    """The columns of numbers, not counts, that are drawn over a timeline; none of the thesis's."""
    return [
        name
        for name in rows[0]
        if TIMELINES[timeline] in name
        and not name.startswith(THESIS)
        and any(isinstance(row[name], float) for row in rows)
    ]
