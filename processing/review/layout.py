"""How a session's recording opens: the object at the left, curves and words at the right, at the last view."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from processing.review.entities import (
    BACKGROUND,
    CLASSES,
    ERRORS,
    EVIDENCE,
    LOG_ERRORS,
    SHARES,
    STAMP_TIMELINE,
    TURNTABLE,
    VIEW_TIMELINE,
)
from processing.timing import STAGES

HIDDEN = rrb.PlotLegend(visible=False)  # colours mean the same in every plot: the first of a tab tells them
FARTHEST_SENSOR = 3.0  # object diameters from the object at which a range scanner's frustum is drawn


@dataclass(frozen=True, eq=False)
class Scene:
    """Where the object stands in frame {0}, which way is up, and where views are drawn to be taken from; metres."""

    center: np.ndarray  # (3,)
    diameter: float
    up: np.ndarray  # (3,), unit
    sensor: np.ndarray | None  # (3,) where a view's frustum stands in the view's frame; None where that is unknown

    @classmethod
    def around(
        cls, points: np.ndarray, elevation_deg: float | None, sensor_origin: tuple[float, float, float] | None
    ) -> Self:
        """The scene of an object whose first view, points (N, 3), looks down on it by `elevation_deg`, if known.

        A view shows the front: the object is taken to be as deep as it is wide. A range scanner's origin is far from
        its frame's: its frustum stands nearer, in the same direction.
        """
        low, high = np.percentile(points, [1, 99], axis=0)
        width = max(float((high - low)[:2].max()), 1e-6)
        center = np.array([*(low + high)[:2] / 2, low[2] + width / 2])
        elevation = np.radians(elevation_deg or 0.0)
        diameter = 1.3 * width
        sensor = None if sensor_origin is None else np.array(sensor_origin)
        if sensor is not None and sensor.any():
            offset = sensor - center
            distance, reach = float(np.linalg.norm(offset)), FARTHEST_SENSOR * diameter
            sensor = center + offset * min(1.0, reach / max(distance, 1e-12))
        return cls(center, diameter, np.array([0.0, -np.cos(elevation), -np.sin(elevation)]), sensor)

    def foot(self, axis: np.ndarray, point: np.ndarray) -> np.ndarray:
        """The point (3,) nearest to the object's centre of a line along a unit axis."""
        return point + np.dot(self.center - point, axis) * axis

    def eye(self) -> rrb.EyeControls3D:
        """An eye behind camera {0}, a little to its right: the object fills the view."""
        return self._look(2.9 * self.diameter, azimuth_deg=25, height_deg=35)

    def eye_on_all(self) -> rrb.EyeControls3D:
        """An eye from so far above that the frusta all round are in its view."""
        ring = self.diameter if self.sensor is None else float(np.linalg.norm(self.sensor - self.center))
        return self._look(max(2.9 * self.diameter, 2.5 * ring), azimuth_deg=25, height_deg=55)

    def _look(self, distance: float, azimuth_deg: float, height_deg: float) -> rrb.EyeControls3D:
        right, forward = np.array([1.0, 0.0, 0.0]), np.array([0.0, self.up[2], -self.up[1]])
        azimuth, height = np.radians(azimuth_deg), np.radians(height_deg)
        level = np.sin(azimuth) * right - np.cos(azimuth) * forward
        position = self.center + distance * (np.cos(height) * level + np.sin(height) * self.up)
        return rrb.EyeControls3D(position=position, look_target=self.center, eye_up=self.up)


def lay_out(
    methods: Sequence[str],
    has_truth: bool,
    scene: Scene | None,
    *,
    has_turntable: bool = False,
    has_mesh: bool = False,
    categories: Sequence[str] = (),
) -> rrb.Blueprint:
    """The blueprint; `methods` from worst to best. Without ground truth the evidence takes the place of the errors."""
    eye = scene.eye() if scene else None
    told = ["/turntable/axis/**", "/free/**"]  # by the poses of the best method
    objects = [
        _view_3d(f"Object by {m}", eye, [f"/object/{m}/**", "/object/truth/**", *(told if m == methods[-1] else [])])
        for m in reversed(methods)
    ]
    wholes = [_view_3d("Model", eye, ["/model/points", "/model/outliers"])]
    wholes += [_view_3d("Mesh", eye, ["/model/mesh"])] if has_mesh else []
    graph = []
    if "refined" in methods:
        contents = ["/graph/**", "/object/refined/**", "/turntable/axis/**"]
        graph.append(_view_3d("Graph", scene.eye_on_all() if scene else None, contents))
    curves = [
        *([_errors()] if has_truth else []),
        _evidence("Evidence", ("overlap", "rmse_m", "violations", "unseen", "misfit", "confidence")),
        _evidence("Support", _support(methods)),
        *([_turntable()] if has_turntable else []),
        *([_classes(categories)] if categories else []),
        _timing(methods),
    ]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Tabs(*objects, *wholes, *graph, _matches(scene)),
            rrb.Vertical(
                rrb.Tabs(*curves),
                rrb.Tabs(
                    rrb.TextDocumentView(origin="/summary", name="Summary"),
                    rrb.TextDocumentView(origin="/table", name="Table"),
                    _log(),
                ),
                row_shares=[3, 2],
            ),
            column_shares=[5, 4],
        ),
        rrb.TimePanel(state="collapsed", timeline=VIEW_TIMELINE, fps=4.0, play_state="following"),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        auto_views=False,
        auto_layout=False,
    )


def _view_3d(
    name: str,
    eye: rrb.EyeControls3D | None,
    contents: Sequence[str],
    time_ranges: Sequence[rrb.VisibleTimeRange] | None = None,
) -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        origin="/",
        contents=contents,
        name=name,
        background=BACKGROUND,
        line_grid=False,
        eye_controls=eye,
        defaults=[rr.TransformAxes3D.from_fields(axis_length=0.0)],  # else every frustum carries three arrows
        time_ranges=time_ranges,
    )


def _matches(scene: Scene | None) -> rrb.Spatial3DView:
    """The pair of the view at the cursor alone: what is logged at other views is out of the time range."""
    eye = None
    if scene:
        eye = rrb.EyeControls3D(position=(0, 0, -2 * scene.diameter), look_target=(0, 0, 0), eye_up=(0, -1, 0))
    here = rrb.TimeRangeBoundary.cursor_relative()
    ranges = [rrb.VisibleTimeRange(timeline, start=here, end=here) for timeline in (VIEW_TIMELINE, STAMP_TIMELINE)]
    return _view_3d("Matches", eye, ["/pairs/**"], ranges)


def _curves(
    origin: str, title: str, contents: Sequence[str] = ("$origin/**",), **options: object
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        contents=contents,
        name=title,
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        interaction=rrb.PlotInteraction(points_display="Always"),
        **{"plot_legend": HIDDEN, **options},
    )


def _errors() -> rrb.Grid:
    """Each error beside its logarithm: Rerun's axes are linear, and the methods differ by orders of magnitude."""
    plots = []
    for quantity, (title, error, _) in LOG_ERRORS.items():
        legend = HIDDEN if plots else rrb.Corner2D.LeftTop
        plots.append(_curves(f"/errors/{error}", ERRORS[error], plot_legend=legend))
        plots.append(_curves(f"/errors_log10/{quantity}", title))
    return rrb.Grid(*plots, grid_columns=2, name="Errors")


def _evidence(name: str, shown: Sequence[str]) -> rrb.Grid:
    plots = []
    for quantity in shown:
        axis = rrb.ScalarAxis(range=(0.0, 1.05)) if quantity in SHARES else None
        legend = HIDDEN if plots else rrb.Corner2D.LeftBottom
        plots.append(_curves(f"/evidence/{quantity}", EVIDENCE[quantity], axis_y=axis, plot_legend=legend))
    return rrb.Grid(*plots, grid_columns=2, name=name)


def _support(methods: Sequence[str]) -> list[str]:
    """What holds a view, as far as the methods look at it."""
    matching = ["inlier_ratio", "matches"] if set(methods) != {"icp"} else []
    return ["observability", *(["edges"] if "refined" in methods else []), *matching]


def _turntable() -> rrb.Vertical:
    plots = [_curves(f"/turntable/{name}", title) for name, title in TURNTABLE.items()]
    return rrb.Vertical(*plots, name="Turntable")


def _classes(categories: Sequence[str]) -> rrb.Vertical:
    """What each view shows alone, and all so far together; one legend for both."""
    share = rrb.ScalarAxis(range=(0.0, 1.05))
    alone, fused = ([f"/classification/{path}{name}" for name in categories] for path in ("", "fused/"))
    return rrb.Vertical(
        _curves("/classification", CLASSES["alone"], alone, axis_y=share, plot_legend=rrb.Corner2D.LeftBottom),
        _curves("/classification/fused", CLASSES["fused"], fused, axis_y=share),
        _curves("/classification/entropy", CLASSES["entropy"]),
        row_shares=[4, 4, 2],
        name="Class",
    )


def _timing(methods: Sequence[str]) -> rrb.Vertical:
    best = methods[-1]
    title = "Time per view [s]" + (", the joint refinement at the end left out" if best == "refined" else "")
    return rrb.Vertical(
        _curves("/timing/total", title, plot_legend=rrb.Corner2D.LeftTop),
        _curves(
            "/timing",
            f"Time per view and stage, {best} [s]",
            [f"/timing/{stage}/{best}" for stage in STAGES],
            plot_legend=rrb.Corner2D.LeftTop,
        ),
        name="Timing",
    )


def _log() -> rrb.TextLogView:
    columns = rrb.TextLogColumns(timeline_columns=[VIEW_TIMELINE], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin="/log", name="Log", columns=columns)
