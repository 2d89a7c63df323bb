"""A headless Rerun viewer for tests: opens a recording, tells what a view could not draw, takes its picture."""

from functools import partial

from orbitscan.processing.review import picture
from orbitscan.processing.review.picture import NoViewer, find_reports, find_viewer, show_tab

__all__ = ["RERUN", "NoViewer", "find_reports", "open_viewer", "show_tab"]

picture.SECONDS_TO_SETTLE = 0.3  # a view tells what it cannot draw in its first frame; no legend is looked at here
open_viewer = partial(picture.open_viewer, size="640x400")  # a software renderer's time goes into pixels
RERUN = find_viewer()  # the native program; the one on the PATH is a wrapper around it
