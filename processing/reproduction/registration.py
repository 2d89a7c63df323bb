"""Figures 5.8 and 5.10: the errors of each frame and the seconds of each object, ICP against RANSAC and then ICP."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from processing.reproduction import drawing
from processing.reproduction.claims import compare
from processing.reproduction.plan import Plan
from processing.reproduction.registration_runs import CIRCLE, FEW, METHODS, OBJECTS, Run, run_all
from processing.reproduction.report import Report

THESIS = ("icp", "ransac_icp")  # the methods of figures 5.9 and 5.10
ERRORS = {  # of errors.csv -> name, unit, factor
    "translation_error_m": ("translation error", "mm", 1000.0),
    "rotation_error_chordal": ("rotation error", "chordal", 1.0),
}
_LEAST = 1e-6  # what a logarithmic axis shows of no error


def compare_errors(plan: Plan) -> Report:
    """Figure 5.8: translation (5.1) and rotation errors (5.2) of every frame by every method."""
    runs = run_all(plan)
    sparse, dense = _part(runs, dense=False), _part(runs, dense=True)
    return Report(
        "figure-5.8",
        "Errors of each frame",
        [row for part in (sparse, dense) for row in tabulate_errors(part)],
        [*_claim(sparse), *_describe_controls(sparse), *_describe_dense(dense)],
        {"figure-5.8": draw_errors(sparse), "figure-5.8-all": draw_errors(dense)},
        _describe_settings(dense),
    )


def compare_seconds(plan: Plan) -> Report:
    """Figure 5.10: seconds of an object's registration and of the removal of outliers."""
    runs = [run for run in run_all(plan) if run.method in THESIS]
    sparse, dense = _part(runs, dense=False), _part(runs, dense=True)
    rows = [row for part in (sparse, dense) for row in _tabulate_seconds(part)]
    figure, (axes,) = drawing.new_figure(1, 2, width=10, height=3.8)
    for each, part in zip(axes, (sparse, dense), strict=True):
        views = part[0].circle.views
        drawing.draw_stacks(each, _stack([row for row in rows if row["views"] == views and row["part"] == _name(part)]))
        each.set_title(f"{views} views, {_name(part)}", fontsize=10)
    drawing.legend_below(figure, axes[0])
    return Report(
        "figure-5.10",
        "Seconds of each object",
        rows,
        [_compare_seconds(part) for part in (sparse, dense)],
        {"figure-5.10": figure},
        _describe_settings(dense) | {"threads": 1},
    )


def tabulate_errors(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """A row for each object and method: errors of all views after the first, means over the runs."""
    return [
        {
            "object": what,
            "views": found[0].circle.views,
            "part": _name(found),
            "method": method,
            "runs": len(found),
            "failed_views": _mean([sum(view["status"] != "ok" for view in run.views) for run in found]),
            "median_translation_mm": _mean([1000 * np.median(run.errors("translation_error_m")) for run in found]),
            "max_translation_mm": _mean([1000 * max(run.errors("translation_error_m")) for run in found]),
            "median_chordal": _mean([np.median(run.errors("rotation_error_chordal")) for run in found]),
            "max_chordal": _mean([max(run.errors("rotation_error_chordal")) for run in found]),
            "max_center_mm": _mean([1000 * max(run.errors("center_error_m")) for run in found]),
        }
        for what in OBJECTS
        for method in METHODS
        if (found := _of(runs, what, method))
    ]


def draw_errors(runs: Sequence[Run]) -> drawing.Figure:
    """Both errors of every frame, a column for each object; of several runs their median and range."""
    figure, rows = drawing.new_figure(2, len(OBJECTS), width=13, height=5.2)
    for line, (key, (name, unit, factor)) in zip(rows, ERRORS.items(), strict=True):
        for axes, what in zip(line, OBJECTS, strict=True):
            series = {method: factor * _curves(_of(runs, what, method), key) for method in METHODS}
            views = range(1, next(iter(series.values())).shape[1] + 1)
            drawing.draw_curves(axes, views, series, "", "view")
            axes.set_yscale("log")
            if key == next(iter(ERRORS)):
                axes.set_title(what.replace("_", " "), fontsize=10)
        line[0].set_ylabel(f"{name} [{unit}]")
    drawing.legend_below(figure, rows[0, 0])
    return figure


def _part(runs: Sequence[Run], dense: bool) -> list[Run]:
    return [run for run in runs if run.circle.dense == dense]


def _of(runs: Sequence[Run], what: str, method: str) -> list[Run]:
    return [run for run in runs if run.circle.what == what and run.method == method]


def _name(runs: Sequence[Run]) -> str:
    circle = runs[0].circle
    if not circle.dense:
        return f"{360 / FEW:g} degrees apart"
    return f"{360 / CIRCLE:g} degrees apart"


def _curves(runs: Sequence[Run], key: str) -> np.ndarray:
    """(runs, views - 1); NaN where a view has no estimate."""
    rows = [[np.nan if view[key] is None else max(view[key], _LEAST) for view in run.views[1:]] for run in runs]
    return np.array(rows, dtype=float)


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))


def _claim(runs: Sequence[Run]) -> list[str]:
    """Of each object: whether RANSAC before ICP makes the errors smaller, the largest ones of paired runs."""
    said = []
    for key, (name, unit, factor) in ERRORS.items():
        for what in OBJECTS:
            icp, ransac = ([factor * max(run.errors(key)) for run in _of(runs, what, method)] for method in THESIS)
            text = f"RANSAC before ICP makes the largest {name} of the {what.replace('_', ' ')} smaller"
            said.append(str(compare(text, icp, ransac, unit)))
    return said


def _describe_controls(runs: Sequence[Run]) -> list[str]:
    worst = {
        method: max(max(run.errors("rotation_error_chordal")) for run in runs if run.method == method)
        for method in METHODS
    }
    failed = {
        method: sum(view["status"] != "ok" for run in runs if run.method == method for view in run.views)
        for method in METHODS
    }
    largest = ", ".join(f"{method} {worst[method]:.3g} ({failed[method]} views not ok)" for method in METHODS)
    return [f"Largest chordal error over all objects and runs, {_name(runs)}: {largest}."]


def _describe_dense(runs: Sequence[Run]) -> list[str]:
    better = [
        what
        for what in OBJECTS
        if max(_of(runs, what, "ransac_icp")[0].errors("rotation_error_chordal"))
        < max(_of(runs, what, "icp")[0].errors("rotation_error_chordal"))
    ]
    names = ", ".join(name.replace("_", " ") for name in better) or "none"
    return [
        f"With {runs[0].circle.views} views {_name(runs)}, one run, RANSAC before ICP has the smaller largest rotation "
        f"error for {len(better)} of {len(OBJECTS)} objects: {names}.",
        *_describe_controls(runs),
    ]


def _tabulate_seconds(runs: Sequence[Run]) -> list[dict[str, Any]]:
    return [
        {
            "object": what,
            "views": found[0].circle.views,
            "part": _name(found),
            "method": method,
            "runs": len(found),
            "registration_s": _mean([run.seconds["registration"] for run in found]),
            "outlier_removal_s": _mean([run.seconds["outlier_removal"] for run in found]),
        }
        for what in OBJECTS
        for method in THESIS
        if (found := _of(runs, what, method))
    ]


def _stack(rows: Sequence[dict[str, Any]]) -> dict[str, dict[str, tuple[float, float]]]:
    """By method and stage -> by object the seconds, as `draw_stacks` wants them."""
    return {
        f"{row['object'].replace('_', ' ')}": {
            other["method"]: (other["registration_s"], other["outlier_removal_s"])
            for other in rows
            if other["object"] == row["object"]
        }
        for row in rows
    }


def _compare_seconds(runs: Sequence[Run]) -> str:
    ratios = {
        what: np.median([run.seconds["registration"] for run in _of(runs, what, "ransac_icp")])
        / np.median([run.seconds["registration"] for run in _of(runs, what, "icp")])
        for what in OBJECTS
    }
    said = ", ".join(f"{what.replace('_', ' ')} {ratio:.2f}" for what, ratio in ratios.items())
    return f"Registration by ransac_icp takes, as a multiple of icp's seconds, {_name(runs)}: {said}."


def _describe_settings(dense: Sequence[Run]) -> dict[str, Any]:
    return {
        "elevation_deg": 30,
        "focal_pixels": OBJECTS,
        "noise_mm_at_1_m": 1,
        "views_of_a_circle": CIRCLE,
        "dense_views": dense[0].circle.views,
    }
