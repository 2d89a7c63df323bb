"""Error curves for papers and reports, from results.json: a curve for each method over the views of a session."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from orbitscan.processing.results.estimates import MethodResult, ViewEstimate
from orbitscan.processing.results.folder import Results, read_results
from orbitscan.processing.results.status import Method, Status
from orbitscan.processing.review.curves import ROUNDING
from orbitscan.processing.review.figures import style
from orbitscan.processing.review.figures.style import ERRORS, STYLE, Quantity, method_color, method_line

CROWDED = 60  # views, from which on a curve's points would hide each other
BESIDE = 0.15  # of a view, between the marks of two methods
EVIDENCE = (
    Quantity("overlap", "overlap with the\nearlier view [share]", whole=True),
    Quantity("rmse_m", "residual of the\noverlap, RMS [mm]", 1e3),
    Quantity("confidence", "confidence [0 to 1]", whole=True),
)
_MARK: dict[str, Any] = {"color": "black", "markersize": 8, "markeredgewidth": 1.3, "linestyle": "none", "zorder": 4}
_NO_POSE: dict[str, Any] = {"marker": "x", "markersize": 4.5, "linestyle": "none", "zorder": 4}


def write_figures(folder: Path) -> list[Path]:
    """Write `figures/errors`, or `figures/evidence` where no truth is known, of a results folder; the paths.

    None where there is nothing to draw: a single view without truth. Raises UnwritableOutput.
    """
    results = read_results(folder).results
    return [
        path
        for name, figure in draw_session(results).items()
        for path in style.save(figure, folder / style.FOLDER / name)
    ]


def draw_session(results: Results) -> dict[str, Figure]:
    """The figure of a session by its name: `errors` against the truth, else the `evidence` of the pairs."""
    errors = {
        method: {v.view: asdict(v.errors) for v in found.views} for method, found in results.reconstruction.items()
    }
    if any(view[ERRORS[0].name] is not None for views in errors.values() for view in views.values()):
        return {"errors": _draw(results, ERRORS, errors, f"{results.session.name}: errors against the ground truth")}
    evidence = {method: _evidence(found) for method, found in results.reconstruction.items()}
    if any(evidence.values()):
        title = f"{results.session.name}: how well the views fit, no ground truth"
        return {"evidence": _draw(results, EVIDENCE, evidence, title)}
    return {}


def _draw(
    results: Results,
    quantities: Sequence[Quantity],
    values: Mapping[Method, Mapping[int, Mapping[str, float | None]]],
    title: str,
) -> Figure:
    """A plot for each quantity over the views, a curve for each method; `values` by method, view and quantity."""
    used = sorted(results.session.views_used)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.0, 7.0), layout="constrained", dpi=150)
        plots = figure.subplots(len(quantities), 1, sharex=True)
        for axes, quantity in zip(plots, quantities, strict=True):
            curves = {
                method: np.array([_value(of_method.get(view, {}), quantity) for view in used])
                for method, of_method in values.items()
            }
            _draw_curves(axes, used, curves, quantity)
            for number, (method, curve) in enumerate(curves.items()):
                _mark_failed(axes, results.reconstruction[method].views, used, curve, method, number)
        plots[-1].set_xlabel("view (recorded index)")
        plots[-1].set_xlim(used[0] - 0.5, used[-1] + 0.5)  # views without values have a place too
        plots[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
        figure.suptitle(title, fontsize=10)
        handles = [Line2D([], [], label=method, **method_line(method, marked=True)) for method in values]
        handles += _legend_marks(results)
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8, columnspacing=1.2)
    return figure


def _draw_curves(axes: Axes, used: Sequence[int], curves: Mapping[Method, np.ndarray], quantity: Quantity) -> None:
    largest = [np.nanmax(curve) for curve in curves.values() if np.nanmax(curve, initial=0.0) > 0]
    logarithmic = not quantity.whole and style.needs_logarithm(largest)
    for method, curve in curves.items():
        if logarithmic:  # what is of the arithmetic, as view {0}'s, has no logarithm
            curve = np.where(curve > ROUNDING * quantity.factor, curve, np.nan)
        axes.plot(used, curve, **method_line(method, marked=len(used) < CROWDED))
    if logarithmic:
        axes.set_yscale("log")
    elif quantity.whole:
        axes.set_ylim(-0.02, 1.05)
    else:
        axes.set_ylim(bottom=0.0)
    axes.set_ylabel(quantity.label)


def _mark_failed(
    axes: Axes, views: Sequence[ViewEstimate], used: Sequence[int], curve: np.ndarray, method: Method, number: int
) -> None:
    """Marks on the curve of what is not ok, and on the axis of what has no pose, those of the methods side by side."""
    status = {view.view: None if view.T_0_i is None else view.status for view in views}
    for view, value in zip(used, curve, strict=True):
        if status[view] is None:
            place: dict[str, Any] = {"transform": axes.get_xaxis_transform(), "clip_on": False}
            aside = BESIDE * (number - 1.5)
            axes.plot([view + aside], [0.0], color=method_color(method), **_NO_POSE, **place)
        elif status[view] != Status.OK and np.isfinite(value):
            axes.plot([view], [value], marker="+" if status[view] == Status.AMBIGUOUS else "x", **_MARK)


def _legend_marks(results: Results) -> list[Line2D]:
    """The marks that occur, in words."""
    views = [view for found in results.reconstruction.values() for view in found.views]
    placed = {view.status for view in views if view.T_0_i is not None}
    marks = [Line2D([], [], marker="+", label="ambiguous", **_MARK)] if Status.AMBIGUOUS in placed else []
    marks += [Line2D([], [], marker="x", label="failed", **_MARK)] if any(s.rank == 0 for s in placed) else []
    if any(view.T_0_i is None for view in views):
        marks.append(Line2D([], [], color="#666666", label="no pose, on the axis", **_NO_POSE))
    return marks


def _value(of_view: Mapping[str, float | None], quantity: Quantity) -> float:
    value = of_view.get(quantity.name)
    return np.nan if value is None else quantity.factor * value


def _evidence(found: MethodResult) -> dict[int, dict[str, float | None]]:
    """View -> the evidence and the confidence of the pair that speaks for it."""
    return {view: asdict(pair.evidence) | {"confidence": pair.confidence} for view, pair in found.speaking.items()}
