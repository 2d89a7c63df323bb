"""How a session's recording opens: the object at the left, curves and words at the right, at the last view."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from processing.review.entities import BACKGROUND, ERRORS, EVIDENCE, LOG_ERRORS, SHARES, STAMP_TIMELINE, VIEW_TIMELINE
from processing.timing import STAGES

FARTHEST_SENSOR = 3.0  # object diameters from the object at which a range scanner's frustum is drawn


@dataclass(frozen=True, eq=False)
class Scene:
    """Where the object stands in frame {0} and which way is up; metres."""

    center: np.ndarray  # (3,)
    diameter: float
    up: np.ndarray  # (3,), unit

    @classmethod
    def around(cls, points: np.ndarray, elevation_deg: float | None) -> Self:
        """The scene of an object whose first view, points (N, 3), looks down on it by `elevation_deg`, if known.

        A view shows the front: the object is taken to be as deep as it is wide.
        """
        low, high = np.percentile(points, [1, 99], axis=0)
        width = max(float((high - low)[:2].max()), 1e-6)
        center = np.array([*(low + high)[:2] / 2, low[2] + width / 2])
        elevation = np.radians(elevation_deg or 0.0)
        return cls(center, 1.3 * width, np.array([0.0, -np.cos(elevation), -np.sin(elevation)]))

    def place_sensor(self, origin: tuple[float, float, float] | None) -> np.ndarray | None:
        """Where a view's frustum stands in the view's frame; None where the sensor's origin is unknown.

        A range scanner's origin is far from its frame's: the frustum stands nearer, in the same direction.
        """
        if origin is None:
            return None
        sensor = np.array(origin)
        offset = sensor - self.center
        distance, reach = float(np.linalg.norm(offset)), FARTHEST_SENSOR * self.diameter
        return sensor if distance <= reach or not sensor.any() else self.center + offset * (reach / distance)

    def eye(self) -> rrb.EyeControls3D:
        """An eye behind camera {0}, a little to its right: the object fills the view, the far cameras are in it."""
        right, forward = np.array([1.0, 0.0, 0.0]), np.array([0.0, self.up[2], -self.up[1]])
        azimuth, height = np.radians(25), np.radians(35)
        level = np.sin(azimuth) * right - np.cos(azimuth) * forward
        position = self.center + 2.9 * self.diameter * (np.cos(height) * level + np.sin(height) * self.up)
        return rrb.EyeControls3D(position=position, look_target=self.center, eye_up=self.up)


def lay_out(methods: Sequence[str], has_truth: bool, scene: Scene | None) -> rrb.Blueprint:
    """The blueprint; `methods` from worst to best. Without ground truth the evidence takes the place of the errors."""
    eye = scene.eye() if scene else None
    objects = [_view_3d(f"Object by {m}", eye, [f"/object/{m}/**", "/object/truth/**"]) for m in reversed(methods)]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Tabs(*objects, _view_3d("Model and outliers", eye, ["/model/**"]), _matches(scene)),
            rrb.Vertical(
                rrb.Tabs(*([_errors()] if has_truth else []), _evidence(methods), _timing(methods)),
                rrb.Tabs(
                    rrb.TextDocumentView(origin="/summary", name="Summary"),
                    rrb.TextDocumentView(origin="/table", name="Table"),
                    _log(),
                ),
                row_shares=[2, 1],
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
    return _view_3d("Matches of the view at the cursor", eye, ["/pairs/**"], ranges)


def _curves(
    origin: str, title: str, contents: Sequence[str] = ("$origin/**",), **options: object
) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        contents=contents,
        name=title,
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        interaction=rrb.PlotInteraction(points_display="Always"),
        **{"plot_legend": rrb.Corner2D.LeftTop, **options},
    )


def _errors() -> rrb.Grid:
    """Each error beside its logarithm: Rerun's axes are linear, and the methods differ by orders of magnitude."""
    plots = []
    for quantity, (title, error, _) in LOG_ERRORS.items():
        plots.append(_curves(f"/errors/{error}", ERRORS[error]))
        plots.append(_curves(f"/errors_log10/{quantity}", title, plot_legend=rrb.PlotLegend(visible=False)))
    return rrb.Grid(*plots, grid_columns=2, name="Errors")


def _evidence(methods: Sequence[str]) -> rrb.Grid:
    shown = ["overlap", "rmse_m", "observability", "confidence"]
    if set(methods) != {"icp"}:  # which matches nothing
        shown += ["inlier_ratio", "matches"]
    plots = []
    for quantity in shown:
        axis = rrb.ScalarAxis(range=(0.0, 1.05)) if quantity in SHARES else None
        plots.append(
            _curves(f"/evidence/{quantity}", EVIDENCE[quantity], axis_y=axis, plot_legend=rrb.Corner2D.LeftBottom)
        )
    return rrb.Grid(*plots, grid_columns=2, name="Evidence")


def _timing(methods: Sequence[str]) -> rrb.Vertical:
    best = methods[-1]
    return rrb.Vertical(
        _curves("/timing/total", "Time per view [s]"),
        _curves("/timing", f"Time per view and stage, {best} [s]", [f"/timing/{stage}/{best}" for stage in STAGES]),
        name="Timing",
    )


def _log() -> rrb.TextLogView:
    columns = rrb.TextLogColumns(timeline_columns=[VIEW_TIMELINE], text_log_columns=["loglevel", "body"])
    return rrb.TextLogView(origin="/log", name="Log", columns=columns)
