"""Figures 5.8 and 5.10: the errors of each frame and the seconds of each object, ICP against RANSAC and then ICP."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from orbitscan.processing.reproduction.drawing import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.errors import (
    THESIS,
    claim_each_object,
    claim_objects,
    describe_gate,
    describe_methods,
    draw_errors,
    name_part,
    of,
    tabulate_errors,
)
from orbitscan.processing.reproduction.registration.run import CIRCLE, ELEVATION_DEG, OBJECTS, Run, run_all
from orbitscan.processing.reproduction.report import Report
from orbitscan.processing.settings import Settings

_SHOWN = (
    "object",
    "views",
    "part",
    "method",
    "failed_views",
    "median_translation_mm",
    "max_translation_mm",
    "median_chordal",
    "max_chordal",
    "max_center_mm",
)
_TIMED = (
    "Wall-clock seconds of one thread for each object, as many objects at the same time as there were workers: other "
    "work on the machine makes them longer. Registration has the preparation of the views, not their reading; the "
    "removal of outliers has the reading and merging of the views before it."
)


def compare_errors(plan: Plan) -> Report:
    """Figure 5.8: translation (5.1) and rotation errors (5.2) of every frame by every method."""
    runs = run_all(plan)
    sparse, dense = _part(runs, dense=False), _part(runs, dense=True)
    return Report(
        "figure-5.8",
        "Errors of each frame",
        [row for part in (sparse, dense) for row in tabulate_errors(part)],
        [
            *(sentence for part in (sparse, dense) for sentence in claim_objects(part)),
            *claim_each_object(sparse),
            describe_gate(sparse, dense),
            *map(describe_methods, (sparse, dense)),
        ],
        {"figure-5.8": draw_errors(sparse), "figure-5.8-all": draw_errors(dense)},
        _describe_settings(dense),
        _SHOWN,
    )


def compare_seconds(plan: Plan) -> Report:
    """Figure 5.10: seconds of an object's registration and of the removal of outliers."""
    runs = [run for run in run_all(plan) if run.method in THESIS]
    sparse, dense = _part(runs, dense=False), _part(runs, dense=True)
    rows = [row for part in (sparse, dense) for row in _tabulate_seconds(part)]
    figure, (axes,) = charts.new_figure(1, 2, width=10, height=3.8)
    for each, part in zip(axes, (sparse, dense), strict=True):
        views = part[0].circle.views
        charts.draw_stacks(
            each, _stack([row for row in rows if row["views"] == views and row["part"] == name_part(part)])
        )
        each.set_title(f"{views} views, {name_part(part)}", fontsize=10)
    charts.legend_below(figure, axes[0])
    return Report(
        "figure-5.10",
        "Seconds of each object",
        rows,
        [*map(_compare_seconds, (sparse, dense)), _TIMED],
        {"figure-5.10": figure},
        _describe_settings(dense) | {"threads": 1},
    )


def _part(runs: Sequence[Run], dense: bool) -> list[Run]:
    return [run for run in runs if run.circle.dense == dense]


def _tabulate_seconds(runs: Sequence[Run]) -> list[dict[str, Any]]:
    return [
        {
            "object": what,
            "views": found[0].circle.views,
            "part": name_part(found),
            "method": method,
            "runs": len(found),
            "registration_s": _average([run.seconds["registration"] for run in found]),
            "outlier_removal_s": _average([run.seconds["outlier_removal"] for run in found]),
        }
        for what in OBJECTS
        for method in THESIS
        if (found := of(runs, what, method))
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
        what: np.median([run.seconds["registration"] for run in of(runs, what, "ransac_icp")])
        / np.median([run.seconds["registration"] for run in of(runs, what, "icp")])
        for what in OBJECTS
    }
    said = ", ".join(f"{what.replace('_', ' ')} {ratio:.2f}" for what, ratio in ratios.items())
    return f"Registration by ransac_icp takes, as a multiple of icp's seconds, {name_part(runs)}: {said}."


def _describe_settings(dense: Sequence[Run]) -> dict[str, Any]:
    return {
        "elevation_deg": ELEVATION_DEG,
        "focal_pixels": OBJECTS,
        "noise_mm_at_1_m": 1,
        "icp_gate_resolutions": Settings().pair.refinement.icp_gate,
        "views_of_a_circle": CIRCLE,
        "dense_views": dense[0].circle.views,
    }


def _average(values: Sequence[float]) -> float:
    return float(np.mean(values))
