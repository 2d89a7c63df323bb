"""Counts against occupancy in the voxels: the thesis's reason for (3.20), which it never measured."""

from typing import Literal

from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.processing.reproduction.claims import compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.training.initializations import draw_run_boxes
from orbitscan.processing.reproduction.training.run import average, column, run_trainings

VALUES: tuple[Literal["counts", "occupancy"], ...] = ("counts", "occupancy")


def compare_values(plan: Plan) -> Report:
    """A study of accuracy, loss and overfitting of the best structure on grids of counts and of occupancy."""
    changes = {str(values): {"voxels": VoxelSettings(values=values)} for values in VALUES}
    runs = run_trainings(plan, changes, "Training on counts and occupancy")
    rows: list[Row] = [
        {
            "voxels hold": values,
            "accuracy_percent": average(found, "accuracy", 100),
            "loss": average(found, "loss"),
            "overfitting": average(found, "overfitting"),
        }
        for values, found in runs.items()
    ]
    counts, occupancy = runs.values()
    more, less = (column(found, "accuracy", 100) for found in (counts, occupancy))
    claims = [
        compare("Counts are more accurate than occupancy", more, less, "points"),
        compare("Counts have a smaller loss than occupancy", column(occupancy, "loss"), column(counts, "loss"), "nats"),
    ]
    figure = draw_run_boxes(runs, width=8)
    return Report("study-counts", "Counts against occupancy", rows, claims=claims, figures={"study-counts": figure})
