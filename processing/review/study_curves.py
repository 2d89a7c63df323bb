"""The curves that are in a study's rows: quantities over the steps of a training, or over the views of a circle."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from orbitscan.processing.review.columns import THESIS, is_number

TIMELINES = {"step": "", "view": "error"}  # columns that count -> what is in the names of the quantities over them
_STATUS = "status"  # is no label: it changes along a curve
_LINES = "method"  # the label that tells lines apart, where a study has several; else the last


@dataclass(frozen=True)
class Curve:
    """A quantity as it goes on."""

    plot: str  # of which it is a line: an object's name; '' where all lines are in one plot
    quantity: str  # as the column is named, with its unit
    line: str
    timeline: str  # one of TIMELINES
    times: tuple[int, ...]
    values: tuple[float, ...]


def find_timeline(rows: Sequence[Mapping[str, Any]]) -> str | None:
    """The column of the rows that counts steps or views; None where nothing goes on along one."""
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
