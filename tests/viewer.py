"""A headless Rerun viewer for tests: opens a recording, tells what a view could not draw, takes its picture."""

from processing.review.picture import NoViewer, find_reports, find_viewer, open_viewer, show_tab

__all__ = ["RERUN", "NoViewer", "find_reports", "open_viewer", "show_tab"]

RERUN = find_viewer()  # the native program; the one on the PATH is a wrapper around it
