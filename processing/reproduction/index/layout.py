"""How a reproduction's recording opens: which claims hold, then a tab for each group and in it for each study."""

import struct
from collections.abc import Mapping, Sequence

import numpy as np
import rerun.blueprint as rrb

from orbitscan.processing.reproduction.claims import Verdict
from orbitscan.processing.reproduction.index.claims_grid import view_claims
from orbitscan.processing.reproduction.index.columns import name_column
from orbitscan.processing.reproduction.index.study import Curve, StudyReview, collect_claims
from orbitscan.processing.review.entities import entity_path
from orbitscan.processing.review.panels import HIDDEN, make_blueprint, view_3d

SHARED_TIMELINE = "step_or_view"  # the viewer plots over one timeline at a time: here all curves are on it
_EYE = np.array([0.8, 0.8, 0.7])  # from an object's centre, in its sizes
_WIDE = 1.7  # width to height of a figure below which its words stand, not beside it


def lay_out(groups: Mapping[str, Sequence[StudyReview]]) -> rrb.Blueprint:
    """The blueprint: a tab for the claims, then one for each group, with a tab for each of its studies."""
    tabs = [rrb.Tabs(*map(_view_study, group), name=name) for name, group in groups.items() if group]
    studies = [study for group in groups.values() for study in group]
    curves = any(study.curves for study in studies)
    return make_blueprint(
        rrb.Tabs(_view_summary(studies), *tabs, active_tab=0),
        rrb.TimePanel(state="collapsed", timeline=SHARED_TIMELINE) if curves else rrb.TimePanel(state="hidden"),
    )


def _view_summary(studies: Sequence[StudyReview]) -> rrb.Horizontal:
    lists = [rrb.TextDocumentView(origin=entity_path("summary", "lists", v), name=v.capitalize()) for v in Verdict]
    return rrb.Horizontal(
        rrb.Vertical(
            rrb.TextDocumentView(origin="/summary/run", name="What was run"),
            view_claims("/summary/claims", collect_claims(studies)),
            row_shares=[2, 3],
        ),
        *lists,
        column_shares=[3, 2, 2, 2],
        name="Summary",
    )


def _view_study(study: StudyReview) -> rrb.Container:
    words = [
        rrb.TextDocumentView(origin=f"{study.origin}/words", name="In words"),
        rrb.TextDocumentView(origin=f"{study.origin}/numbers", name="Numbers"),
    ]
    figures = [
        rrb.Spatial2DView(origin=study.figure_path(name), name=name, background=(255, 255, 255))
        for name in study.figures
    ]
    shown: list[rrb.View | rrb.Container] = [*figures, *_view_models(study)]
    below: list[rrb.Container] = [rrb.Horizontal(*words)]
    if curves := study.curves:
        below.insert(0, _view_curves(study, curves))
    if not shown:
        return rrb.Vertical(*below, name=study.name)
    picture = shown[0] if len(shown) == 1 else rrb.Tabs(*shown)
    if curves or all(_aspect(png) > _WIDE for png in study.figures.values()):
        return rrb.Vertical(picture, *below, row_shares=[3, *([2] * len(below))], name=study.name)
    return rrb.Horizontal(picture, rrb.Vertical(*words), column_shares=[3, 2], name=study.name)


def _view_models(study: StudyReview) -> list[rrb.Horizontal]:
    """A tab for each object, its models side by side, seen from one place."""
    tabs = []
    for thing, models in study.models.items():
        eye = _look_at(np.concatenate([points for points, _ in models.values()]))
        views = [view_3d(study.model_path(thing, method), method, eye) for method in models]
        tabs.append(rrb.Horizontal(*views, name=thing))
    return tabs


def _look_at(points: np.ndarray) -> rrb.EyeControls3D | None:
    """An eye behind points (N, 3), z up, to their right and above: errors add up away from the first camera."""
    if not len(points):
        return None
    low, high = np.percentile(points, [1, 99], axis=0)
    center, size = (low + high) / 2, float(np.linalg.norm(high - low))
    return rrb.EyeControls3D(position=center + _EYE * size, look_target=center, eye_up=(0.0, 0.0, 1.0))


def _view_curves(study: StudyReview, curves: Sequence[Curve]) -> rrb.Container:
    plots = []
    for plot in dict.fromkeys(curve.plot for curve in curves):
        quantities = dict.fromkeys(curve.quantity for curve in curves if curve.plot == plot)
        views = [
            rrb.TimeSeriesView(
                origin=study.plot_path(plot, quantity),
                name=name_column(quantity),
                plot_legend=HIDDEN if i else rrb.Corner2D.RightBottom,
            )
            for i, quantity in enumerate(quantities)
        ]
        plots.append(rrb.Horizontal(*views, name=plot))
    return plots[0] if len(plots) == 1 else rrb.Tabs(*plots)


def _aspect(png: bytes) -> float:
    """Width to height of a PNG picture."""
    width, height = struct.unpack(">II", png[16:24])
    return width / height
