"""The largest errors of a batch's sessions by each method: what a median hides, a point for each session shows."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from orbitscan.processing.results.batch_table import Row, methods_of
from orbitscan.processing.review.figures import style
from orbitscan.processing.review.figures.style import ERRORS, STYLE, Quantity
from orbitscan.processing.review.markdown import plural


def write_batch_figure(folder: Path, rows: Sequence[Row]) -> list[Path]:
    """Write `figures/errors` of a batch into its folder; the paths, none without truth. Raises UnwritableOutput."""
    figure = draw_batch(rows)
    return [] if figure is None else style.save(figure, folder / style.FOLDER / "errors")


def draw_batch(rows: Sequence[Row]) -> Figure | None:
    """Each session's largest errors by each method, with their median; None where no truth is known.

    Below a method stands how many of the sessions have a view that it did not place with confidence.
    """
    methods = methods_of(rows)
    if not any(_largest(rows, method, ERRORS[0]) for method in methods):
        return None
    names = [f"{method}\n{_count_failed(rows, method)}" for method in methods]
    known = max(len(_largest(rows, method, ERRORS[0])) for method in methods)
    with rc_context(STYLE):
        figure = Figure(figsize=(8.5, 3.6), layout="constrained", dpi=150)
        for axes, quantity in zip(figure.subplots(1, len(ERRORS)), ERRORS, strict=True):
            _draw_strips(axes, {method: _largest(rows, method, quantity) for method in methods})
            axes.set_xticks(range(len(methods)), names, fontsize=7)
            axes.set_ylabel("largest " + quantity.label.replace("\n", " "))
        title = f"{known} {plural(known, 'session')} with ground truth: the largest error of each"
        figure.suptitle(title, fontsize=10)
        figure.supxlabel("method; sessions in which a view failed", fontsize=8)
    return figure


def _draw_strips(axes: Axes, samples: Mapping[str, Sequence[float]]) -> None:
    """A point for each session, spread sideways in the order of the sessions, and a bar at the median."""
    for place, (method, values) in enumerate(samples.items()):
        spread = place + (np.linspace(-0.22, 0.22, len(values)) if len(values) > 1 else np.zeros(len(values)))
        mark: dict[str, Any] = {"marker": style.MARKERS[method], "color": style.method_color(method), "alpha": 0.8}
        axes.plot(spread, values, linestyle="none", markersize=4, markeredgewidth=0, **mark)
        if values:
            axes.hlines(np.median(values), place - 0.32, place + 0.32, color="black", linewidth=1.5)
    known = [value for values in samples.values() for value in values]
    if known and min(known) > 0 and style.needs_logarithm(known):
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    axes.set_xlim(-0.6, len(samples) - 0.4)
    axes.grid(visible=False, axis="x")


def _largest(rows: Sequence[Row], method: str, quantity: Quantity) -> list[float]:
    """The largest errors of the sessions that have the method and a truth."""
    found = [row.of(method, f"max_{quantity.name}") for row in rows]
    return [quantity.factor * value for value in found if value is not None]


def _count_failed(rows: Sequence[Row], method: str) -> str:
    counts = [count for row in rows if (count := row.of(method, "failed_views")) is not None]
    return f"{sum(count > 0 for count in counts)} of {len(counts)}"
