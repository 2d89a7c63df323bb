"""The panels that the layouts of all recordings are made of."""

from typing import Any

import rerun.blueprint as rrb

from orbitscan.processing.review import entities

HIDDEN = rrb.PlotLegend(visible=False)  # colours mean the same in every plot: the first of a tab tells them


def make_blueprint(content: rrb.Container | rrb.View, time: rrb.TimePanel) -> rrb.Blueprint:
    """A layout that shows the content alone, with the viewer's own panels folded away."""
    panels = rrb.BlueprintPanel(state="collapsed"), rrb.SelectionPanel(state="collapsed")
    return rrb.Blueprint(content, time, *panels, auto_views=False, auto_layout=False)


def view_curves(
    origin: str, title: str, legend: rrb.PlotLegend | rrb.Corner2D = HIDDEN, **options: Any
) -> rrb.TimeSeriesView:
    """A plot of the curves below `origin`, with a dot at each value."""
    dots = rrb.PlotInteraction(points_display="Always")
    return rrb.TimeSeriesView(origin=origin, name=title, plot_legend=legend, interaction=dots, **options)


def view_3d(origin: str, name: str, eye: rrb.EyeControls3D | None, **options: Any) -> rrb.Spatial3DView:
    """A 3D view on our background, without the grid of a floor."""
    background = entities.BACKGROUND
    return rrb.Spatial3DView(
        origin=origin, name=name, background=background, line_grid=False, eye_controls=eye, **options
    )


def view_log(timeline: str) -> rrb.TextLogView:
    """The lines of `/log` with their times on a timeline."""
    columns = rrb.TextLogColumns(timeline_columns=[timeline], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin="/log", name="Log", columns=columns)
