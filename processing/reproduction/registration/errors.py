"""Figure 5.8: the errors of each frame, by ICP alone, by RANSAC and then ICP, and by our methods."""

from collections.abc import Callable, Sequence
from operator import itemgetter

import numpy as np

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import Claim, Verdict, compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration import run as circles
from orbitscan.processing.reproduction.registration.run import METHODS, OBJECTS, THESIS, Run, choose_runs
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.settings import Settings

ERRORS = {  # of errors.csv -> name, unit, factor
    "translation_error_m": ("translation error", "mm", 1000.0),
    "rotation_error_chordal": ("rotation error", "chordal", 1.0),
}
_LEAST = 1e-6  # what a logarithmic axis shows of no error
_SHOWN: tuple[str, ...] = ("object", "views", "part", "method", "failed_views")
_SHOWN += ("median_translation_mm", "max_translation_mm", "median_chordal", "max_chordal", "max_center_mm")


def compare_errors(plan: Plan) -> Report:
    """Figure 5.8: translation (5.1) and rotation errors (5.2) of every frame by every method."""
    runs = circles.run_all(plan)
    sparse, dense = circles.split_by_spacing(runs)
    return Report(
        "figure-5.8",
        "Errors of each frame",
        [row for part in (sparse, dense) for row in tabulate_errors(part)],
        said=[describe_gate(sparse, dense), *map(describe_methods, (sparse, dense))],
        claims=[*claim_objects(sparse), *claim_objects(dense), *claim_each_object(sparse)],
        figures={"figure-5.8": draw_errors(sparse), "figure-5.8-all": draw_errors(dense)},
        settings=circles.describe_settings(runs),
        shown=_SHOWN,
    )


def tabulate_errors(runs: Sequence[Run]) -> list[Row]:
    """A row for each object and method: errors of all views after the first, means over the runs.

    Views without an estimate have no error; they are counted.
    """
    return [_tabulate(choose_runs(runs, what, method)) for what in OBJECTS for method in METHODS]


def _tabulate(runs: Sequence[Run]) -> Row:
    """The row of an object and a method."""
    translation = [[1000 * error for error in run.errors("translation_error_m")] for run in runs]
    chordal = [run.errors("rotation_error_chordal") for run in runs]
    center = [[1000 * error for error in run.errors("center_error_m")] for run in runs]
    return circles.describe_runs(runs) | {
        "failed_views": float(np.mean([_count_failed(run) for run in runs])),
        "unplaced_views": float(np.mean([run.unplaced for run in runs])),
        "median_translation_mm": _mean_of(np.median, translation),
        "max_translation_mm": _mean_of(max, translation),
        "last_translation_mm": _mean_of(itemgetter(-1), translation),
        "median_chordal": _mean_of(np.median, chordal),
        "max_chordal": _mean_of(max, chordal),
        "last_chordal": _mean_of(itemgetter(-1), chordal),
        "max_center_mm": _mean_of(max, center),
    }


def draw_errors(runs: Sequence[Run]) -> charts.Figure:
    """A figure of both errors of every frame, a column for each object: the mean and the range of the runs."""
    figure, rows = charts.new_figure(2, len(OBJECTS), width=13, height=5.2)
    for line, (key, (name, unit, factor)) in zip(rows, ERRORS.items(), strict=True):
        for axes, what in zip(line, OBJECTS, strict=True):
            series = {method: factor * curves(choose_runs(runs, what, method), key) for method in METHODS}
            views = range(1, next(iter(series.values())).shape[1] + 1)
            charts.draw_curves(axes, views, series, "", "view")
            axes.set_yscale("log")
            if key == next(iter(ERRORS)):
                axes.set_title(what.replace("_", " "), fontsize=10)
        line[0].set_ylabel(f"{name} [{unit}]")
    charts.legend_below(figure, rows[0, 0])
    return figure


def curves(runs: Sequence[Run], key: str) -> np.ndarray:
    """One error of every view after the first, (runs, views - 1); NaN where a view has no estimate."""
    return np.array([_curve(run, key) for run in runs], dtype=float)


def claim_objects(runs: Sequence[Run]) -> list[Claim]:
    """Whether RANSAC before ICP makes the largest errors smaller, as a share of ICP's: every object is one pair."""
    claims = []
    for key, (name, _, _) in ERRORS.items():
        text = f"RANSAC before ICP makes the largest {name} smaller, {runs[0].circle.spacing}"
        means = [np.mean(pairs, axis=0) for what in OBJECTS if (pairs := _pair_largest(runs, what, key))]
        shares = [100 * ransac / icp for icp, ransac in means]
        claims.append(_claim_less(text, [100.0] * len(shares), shares, "% of ICP's error", "object"))
    return claims


def claim_each_object(runs: Sequence[Run]) -> list[Claim]:
    """For each object, whether RANSAC before ICP makes the largest errors smaller: every recording is one pair."""
    claims = []
    for key, (name, unit, factor) in ERRORS.items():
        for what in OBJECTS:
            text = f"RANSAC before ICP makes the largest {name} of the {what.replace('_', ' ')} smaller"
            pairs = _pair_largest(runs, what, key)
            icp, ransac = factor * np.array(pairs).reshape(-1, 2).T
            claims.append(_claim_less(text, icp, ransac, unit))
    return claims


def describe_gate(*parts: Sequence[Run]) -> str:
    """In words: our gate of ICP, which the thesis does not give, and how near the two methods end."""
    said = []
    for runs in parts:
        apart, views = 0, 0
        for what in OBJECTS:
            icp, ransac = (curves(choose_runs(runs, what, method), "rotation_error_chordal") for method in THESIS)
            apart += int((np.abs(icp - ransac) > 0.1 * np.fmax(icp, ransac)).sum())
            views += int(np.isfinite(icp - ransac).sum())
        said.append(f"in {apart} of {views} views {runs[0].circle.spacing}")
    return (
        f"Both pair points within {Settings().pair.refinement.icp_gate:g} working resolutions in ICP: our gate, the "
        "thesis gives none, and what a start is worth depends on it. Their rotation errors differ by more than a tenth "
        f"{', '.join(said)}."
    )


def describe_methods(runs: Sequence[Run]) -> str:
    """In words: the largest rotation error of each method, and how many of its views are not ok."""
    found = {method: [run for run in runs if run.method == method] for method in METHODS}
    worst = {
        method: max((error for run in of_method for error in run.errors("rotation_error_chordal")), default=np.nan)
        for method, of_method in found.items()
    }
    failed = {method: sum(map(_count_failed, of_method)) for method, of_method in found.items()}
    largest = ", ".join(f"{method} {worst[method]:.3g} ({failed[method]} views not ok)" for method in METHODS)
    return f"Largest chordal error over all objects and runs, {runs[0].circle.spacing}: {largest}."


def _claim_less(text: str, icp: Sequence[float], ransac: Sequence[float], unit: str, pair: str = "run") -> Claim:
    """The claim that RANSAC's numbers are smaller than ICP's, which cannot be told where there are none."""
    if not len(icp):
        return Claim(text, Verdict.OPEN, missing="no view has an estimate by both methods")
    return compare(text, icp, ransac, unit, pair)


def _pair_largest(runs: Sequence[Run], what: str, key: str) -> list[tuple[float, float]]:
    """The largest errors of each recording of an object, by ICP and by RANSAC before it, of the views both placed."""
    pairs: list[tuple[float, float]] = []
    for icp, ransac in zip(*(choose_runs(runs, what, method) for method in THESIS), strict=True):
        errors = np.array([_curve(run, key) for run in (icp, ransac)])
        both = np.isfinite(errors).all(axis=0)
        if both.any():
            largest = errors[:, both].max(axis=1)
            pairs.append((float(largest[0]), float(largest[1])))
    return pairs


def _curve(run: Run, key: str) -> list[float]:
    return [np.nan if view[key] is None else max(view[key], _LEAST) for view in run.views[1:]]


def _mean_of(measure: Callable[[Sequence[float]], float], errors: Sequence[Sequence[float]]) -> float | None:
    """The mean over the runs of what is measured of each one's errors; None where none has any."""
    known = [measure(of_run) for of_run in errors if of_run]
    return float(np.mean(known)) if known else None


def _count_failed(run: Run) -> int:
    return sum(view["status"] != "ok" for view in run.views)
