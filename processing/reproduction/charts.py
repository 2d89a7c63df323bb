"""Figures with matplotlib, readable in black and white: hatches and line styles tell apart what colours do."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from orbitscan.processing.review.figures.style import STYLE

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555")  # Okabe and Ito's
LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 3)))
MARKERS = "osD^vPX"
HATCHES = ("", "//", "..", "xx", "\\\\", "++", "oo")
_NOTCHED = 8  # runs; a notch over fewer reaches beyond its box


def new_figure(
    rows: int = 1, columns: int = 1, width: float = 7.0, height: float = 3.2, dpi: int = 150
) -> tuple[Figure, np.ndarray]:
    """A new figure, `width` by `height` inches, and its axes as an array (rows, columns)."""
    with rc_context(STYLE):
        figure = Figure(figsize=(width, height), layout="constrained", dpi=dpi)
        return figure, figure.subplots(rows, columns, squeeze=False)


def draw_boxes(axes: Axes, samples: Mapping[str, Sequence[float]], label: str, sideways: bool = False) -> None:
    """Draw a notched box and the runs as points for each sample; for few runs their points and median alone."""
    median: dict[str, Any] = {"color": "black", "linewidth": 1.5}
    for place, values in enumerate(samples.values()):
        if len(values) >= _NOTCHED:
            way: Literal["horizontal", "vertical"] = "horizontal" if sideways else "vertical"
            box: dict[str, Any] = {"widths": 0.5, "notch": True, "showfliers": False, "medianprops": median}
            axes.boxplot(values, positions=[place], orientation=way, **box)
        else:
            draw = axes.vlines if sideways else axes.hlines
            draw(np.median(values), place - 0.25, place + 0.25, **median)
        spread = place + (np.linspace(-0.12, 0.12, len(values)) if len(values) > 1 else np.zeros(1))
        along = (values, spread) if sideways else (spread, values)
        axes.plot(*along, "o", markersize=3, color=COLORS[0], alpha=0.7, markeredgewidth=0)
    if sideways:
        axes.set_yticks(range(len(samples)), list(samples))
        axes.set_ylim(len(samples) - 0.4, -0.6)
        axes.set_xlabel(label)
    else:
        axes.set_xticks(range(len(samples)), list(samples))
        axes.set_xlim(-0.6, len(samples) - 0.4)
        axes.set_ylabel(label)
    axes.grid(visible=False, axis="y" if sideways else "x")


def draw_curves(axes: Axes, x: Sequence[float], series: Mapping[str, np.ndarray], label: str, x_label: str) -> None:
    """Draw each series of runs (runs, steps) as a curve of their mean, with a band from the least to the most."""
    for i, (name, runs) in enumerate(series.items()):
        runs = np.atleast_2d(runs)
        axes.plot(x, runs.mean(axis=0), linestyle=LINES[i], color=COLORS[i], linewidth=1.5, label=name)
        if len(runs) > 1:
            axes.fill_between(x, runs.min(axis=0), runs.max(axis=0), color=COLORS[i], alpha=0.12, linewidth=0)
    axes.set_xlabel(x_label)
    axes.set_ylabel(label)
    axes.set_xlim(min(x), max(x))


def draw_bars(axes: Axes, groups: Sequence[str], series: Mapping[str, Sequence[float]], label: str) -> None:
    """Draw a bar in each group for each series, and none where its value is NaN."""
    width = 0.8 / len(series)
    places = np.arange(len(groups))
    for i, (name, values) in enumerate(series.items()):
        offset = (i - (len(series) - 1) / 2) * width
        axes.bar(places + offset, values, width, label=name, **bar_style(i))
    axes.set_xticks(places, groups)
    axes.set_ylabel(label)
    axes.grid(visible=False, axis="x")


def draw_stacks(axes: Axes, groups: Mapping[str, Mapping[str, tuple[float, float]]]) -> None:
    """Draw a bar for each method of each group: seconds of registration, on top those of the removal of outliers."""
    for place, methods in enumerate(groups.values()):
        width = 0.8 / len(methods)
        for i, (method, (registration, removal)) in enumerate(methods.items()):
            x = place + (i - (len(methods) - 1) / 2) * width
            named = f"{method}: registration" if not place else None
            axes.bar(x, registration, 0.95 * width, label=named, **bar_style(i))
            named = "removal of outliers" if i == len(methods) - 1 and not place else None
            axes.bar(
                x, removal, 0.95 * width, registration, label=named, color="black", edgecolor="white", linewidth=0.5
            )
    axes.set_xticks(range(len(groups)), list(groups))
    axes.set_ylabel("seconds, one thread")
    axes.grid(visible=False, axis="x")


def bar_style(number: int) -> dict[str, Any]:
    """How the bars of a series look, told apart by hatches too."""
    return {"color": COLORS[number], "hatch": HATCHES[number], "edgecolor": "white", "linewidth": 0.5}


def draw_matrix(axes: Axes, counts: np.ndarray, names: Sequence[str]) -> None:
    """Draw counts (true category, found category) as a confusion matrix in per cent of each row."""
    shares = 100 * counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    draw_shares(axes, shares, shares >= 0.5, fontsize=7)
    axes.set_xticks(range(len(names)), names, rotation=45, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(names)), names)
    axes.set(xlabel="taken for", ylabel="true category")


def draw_shares(axes: Axes, shares: np.ndarray, written: np.ndarray, fontsize: int, **options: Any) -> None:
    """Draw shares (R, C) in per cent as cells, black for all, with the numbers of those that are `written` (R, C)."""
    axes.imshow(shares, cmap="Greys", vmin=0, vmax=100, **options)
    for row, column in zip(*np.nonzero(written), strict=True):
        color = "white" if shares[row, column] > 50 else "black"
        text = f"{shares[row, column]:.0f}"
        axes.text(column, row, text, ha="center", va="center", color=color, fontsize=fontsize)
    axes.grid(visible=False)


def name_row(axes: Axes, x: float, name: str, **options: Any) -> None:
    """Write the name of a row of pictures upwards beside its first axes, at `x` in their widths."""
    axes.text(x, 0.5, name, transform=axes.transAxes, rotation=90, ha="right", va="center", **options)


def legend_below(figure: Figure, axes: Axes) -> None:
    """Place one legend for all axes of a figure below them."""
    handles, names = axes.get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 5), frameon=False)
