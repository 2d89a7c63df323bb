"""The thesis's tables and figures, made again: a module for each, here the list of them.

Every study is a function of a Plan that returns a Report: a list of calls with files between them, so that one that
is stopped goes on where it was.
"""

from collections.abc import Callable
from importlib import import_module

STUDIES = {  # as the command names them, in the thesis's order -> the module and the function
    "gallery": "gallery.show_gallery",
    "figure-3.5": "grids.show_values",
    "figure-3.6": "grids.show_resolutions",
    "study-counts": "counts.compare_values",
    "table-5.1": "structures.compare_structures",
    "table-5.2": "cross_entropy.work_example",
    "table-5.3": "descriptors.compare_descriptors",
    "table-5.4": "initialisations.tabulate",
    "figure-5.1": "initialisations.draw_boxes",
    "figure-5.2": "initialisations.draw_curves",
    "figure-5.3": "orientation.draw_boxes",
    "figure-5.4": "orientation.draw_curves",
    "figure-5.5": "orientation.draw_confusions",
    "figure-5.8": "registration.compare_errors",
    "figure-5.9": "models.show_models",
    "figure-5.10": "registration.compare_seconds",
    "study-overlap": "overlap.vary_overlap",
}


def find(name: str) -> Callable:
    """The function of a study: a Plan in, a Report out."""
    module, function = STUDIES[name].split(".")
    return getattr(import_module(f"orbitscan.processing.reproduction.{module}"), function)
