"""The thesis's tables and figures, made again: a room for each part of it, here the list of them.

Every study is a function of a Plan that returns a Report: a list of calls with files between them, so that one that
is stopped goes on where it was.
"""

from collections.abc import Callable
from importlib import import_module

STUDIES = {  # as the command names them, in the thesis's order -> the module and the function
    "gallery": "views.gallery.show_gallery",
    "figure-3.5": "views.voxelization.show_values",
    "figure-3.6": "views.voxelization.show_resolutions",
    "study-counts": "training.counts.compare_values",
    "table-5.1": "training.structures.compare_structures",
    "table-5.2": "training.cross_entropy.work_example",
    "table-5.3": "descriptors.table.compare_descriptors",
    "table-5.4": "training.initializations.tabulate",
    "figure-5.1": "training.initializations.draw_boxes",
    "figure-5.2": "training.initializations.draw_curves",
    "figure-5.3": "training.orientation.draw_boxes",
    "figure-5.4": "training.orientation.draw_curves",
    "figure-5.5": "training.orientation.draw_confusions",
    "figure-5.8": "registration.errors.compare_errors",
    "figure-5.9": "registration.models.show_models",
    "figure-5.10": "registration.seconds.compare_seconds",
    "study-overlap": "overlap.study.vary_overlap",
}


def find(name: str) -> Callable:
    """The function of a study by its name: it takes a Plan and returns a Report."""
    module, _, function = STUDIES[name].rpartition(".")
    return getattr(import_module(f"orbitscan.processing.reproduction.{module}"), function)
