"""Figure 5.10: the seconds of each object, registered by ICP and by RANSAC and then ICP."""

from collections.abc import Sequence

import numpy as np

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration import run as circles
from orbitscan.processing.reproduction.registration.run import OBJECTS, THESIS, Run, choose_runs
from orbitscan.processing.reproduction.report import Report, Row

_TIMED = (
    "Wall-clock seconds of one thread for each object, as many objects at the same time as there were workers: other "
    "work on the machine makes them longer. Registration has the preparation of the views, not their reading; the "
    "removal of outliers has the reading and merging of the views before it."
)


def compare_seconds(plan: Plan) -> Report:
    """Figure 5.10: seconds of an object's registration and of the removal of outliers."""
    runs = [run for run in circles.run_all(plan) if run.method in THESIS]
    parts = circles.split_by_spacing(runs)
    figure, (axes,) = charts.new_figure(1, 2, width=10, height=3.8)
    for each, part in zip(axes, parts, strict=True):
        stacks = {
            what.replace("_", " "): {
                method: (_average(found, "registration"), _average(found, "outlier_removal"))
                for method in THESIS
                if (found := choose_runs(part, what, method))
            }
            for what in OBJECTS
        }
        charts.draw_stacks(each, stacks)
        each.set_title(f"{part[0].circle.views} views, {part[0].circle.spacing}", fontsize=10)
    charts.legend_below(figure, axes[0])
    return Report(
        "figure-5.10",
        "Seconds of each object",
        [row for part in parts for row in _tabulate(part)],
        said=[*map(_compare_methods, parts), _TIMED],
        figures={"figure-5.10": figure},
        settings=circles.describe_settings(runs) | {"threads": 1},
    )


def _tabulate(runs: Sequence[Run]) -> list[Row]:
    """A row for each object and method: the mean seconds of its runs."""
    return [
        circles.describe_runs(found)
        | {"registration_s": _average(found, "registration"), "outlier_removal_s": _average(found, "outlier_removal")}
        for what in OBJECTS
        for method in THESIS
        if (found := choose_runs(runs, what, method))
    ]


def _compare_methods(runs: Sequence[Run]) -> str:
    """How many times longer registration takes with RANSAC than without, by object."""
    ratios = {what: _median(runs, what, "ransac_icp") / _median(runs, what, "icp") for what in OBJECTS}
    said = ", ".join(f"{what.replace('_', ' ')} {ratio:.2f}" for what, ratio in ratios.items())
    return f"Registration by ransac_icp takes, as a multiple of icp's seconds, {runs[0].circle.spacing}: {said}."


def _median(runs: Sequence[Run], what: str, method: str) -> float:
    return float(np.median([run.seconds["registration"] for run in choose_runs(runs, what, method)]))


def _average(runs: Sequence[Run], stage: str) -> float:
    return float(np.mean([run.seconds[stage] for run in runs]))
