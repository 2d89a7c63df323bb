"""How a session's recording opens: the object at the left, curves and words at the right, at the last view."""

from collections.abc import Mapping, Sequence
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.results.status import Method
from orbitscan.processing.review import entities
from orbitscan.processing.review.entities import STAMP_TIMELINE, VIEW_TIMELINE
from orbitscan.processing.review.panels import HIDDEN, make_blueprint, view_3d, view_curves, view_log
from orbitscan.processing.review.session.scene import Scene
from orbitscan.processing.review.session.shading import Shading
from orbitscan.processing.timing import STAGES

FUNNEL = ("points", "keypoints", "valid_frames", "matches", "inliers", "overlap")


def lay_out(
    methods: Sequence[Method],
    has_truth: bool,
    scene: Scene | None,
    *,
    is_colored: bool = False,
    view_colors: Mapping[int, entities.Color] | None = None,
    shading: Shading | None = None,
    errors: str = entities.ERRORS_ROOT,
    has_bounds: bool = False,
    has_turntable: bool = False,
    has_mesh: bool = False,
    categories: Sequence[str] = (),
) -> rrb.Blueprint:
    """The blueprint; `methods` from worst to best. Without ground truth the evidence takes the place of the errors.

    `view_colors` are those of the best method's views in the tab that shows them by view; `errors` is where the curves
    of errors are.
    """
    *lesser, best = methods
    eye = scene.eye() if scene else None
    whole = [f"/object/{best}/**", "/object/truth/**", "/turntable/axis/**", "/free/**", "/coverage/**"]
    objects = [_view_3d(f"{best}, {'as captured' if is_colored else 'by view'}", eye, whole)]
    if view_colors and is_colored:
        objects.append(_view_3d("by view", eye, whole, colors=_of_clouds(best, view_colors)))
    if view_colors and shading:
        colors = _of_clouds(best, {view: shading.colors[view] for view in view_colors})
        objects.append(_view_3d(f"by {shading.quantity}", eye, [*whole, "/scale/**"], colors=colors))
    objects += [_view_3d(m, eye, [f"/object/{m}/**", "/object/truth/**"]) for m in reversed(lesser)]
    wholes = [_view_3d("Model", eye, ["/model/points", "/model/outliers"])]
    wholes += [_view_3d("Mesh", eye, ["/model/mesh"])] if has_mesh else []
    graph = []
    if "refined" in methods:
        contents = ["/graph/**", "/object/refined/**", "/turntable/axis/**", "/coverage/**"]
        graph.append(_view_3d("Graph", scene.eye_on_all() if scene else None, contents))
    matched = set(methods) != {"icp"}
    curves = [
        *([_errors(errors)] if has_truth else []),
        *([_bounds(methods, errors)] if has_bounds else []),
        _evidence("Evidence", ("overlap", "rmse_m", "violations", "unseen", "misfit", "confidence")),
        _evidence("Funnel", FUNNEL if matched else ("points", "overlap")),
        _evidence("Support", _support(methods)),
        *([_turntable()] if has_turntable else []),
        *([_classes(categories)] if categories else []),
        _timing(methods),
    ]
    return make_blueprint(
        rrb.Horizontal(
            rrb.Tabs(*objects, *wholes, *graph, *([_matches(scene)] if matched else [])),
            rrb.Vertical(
                rrb.Tabs(*curves),
                rrb.Tabs(
                    rrb.TextDocumentView(origin="/summary", name="Summary"),
                    rrb.TextDocumentView(origin="/story", name="View"),
                    rrb.TextDocumentView(origin="/table", name="Table"),
                    view_log(VIEW_TIMELINE),
                ),
                row_shares=[3, 2],
            ),
            column_shares=[5, 4],
        ),
        rrb.TimePanel(state="collapsed", timeline=VIEW_TIMELINE, fps=4.0, play_state="following"),
    )


def _view_3d(
    name: str,
    eye: rrb.EyeControls3D | None,
    contents: Sequence[str],
    time_ranges: Sequence[rrb.VisibleTimeRange] | None = None,
    colors: Mapping[Any, Any] | None = None,
) -> rrb.Spatial3DView:
    bare = [rr.TransformAxes3D.from_fields(axis_length=0.0)]  # else every frustum carries three arrows
    return view_3d("/", name, eye, contents=contents, defaults=bare, time_ranges=time_ranges, overrides=colors)


def _of_clouds(method: Method, colors: Mapping[int, entities.Color]) -> dict[str, rr.Points3D]:
    """One colour for each view's cloud, in place of those in the file, which holds a cloud's points once."""
    return {entities.cloud_path(method, v): rr.Points3D.from_fields(colors=color) for v, color in colors.items()}


def _matches(scene: Scene | None) -> rrb.Spatial3DView:
    """The pair of the view at the cursor alone: what is logged at other views is out of the time range."""
    eye = None
    if scene:
        eye = rrb.EyeControls3D(position=(0, 0, -2 * scene.diameter), look_target=(0, 0, 0), eye_up=(0, -1, 0))
    here = rrb.TimeRangeBoundary.cursor_relative()
    ranges = [rrb.VisibleTimeRange(timeline, start=here, end=here) for timeline in (VIEW_TIMELINE, STAMP_TIMELINE)]
    return _view_3d("Matches", eye, ["/pairs/**"], ranges)


def _curves(
    origin: str,
    title: str,
    legend: rrb.PlotLegend | rrb.Corner2D = HIDDEN,
    contents: Sequence[str] = ("$origin/**",),
    axis_y: rrb.ScalarAxis | None = None,
) -> rrb.TimeSeriesView:
    linked = rrb.TimeAxis(link="LinkToGlobal")
    return view_curves(origin, title, legend, contents=contents, axis_x=linked, axis_y=axis_y)


def _errors(root: str) -> rrb.Grid:
    """Each error beside its logarithm: Rerun's axes are linear, and the methods differ by orders of magnitude."""
    plots: list[Any] = []
    for quantity, (title, error, _) in entities.LOG_ERRORS.items():
        legend = HIDDEN if plots else rrb.Corner2D.LeftTop
        shown = quantity if quantity in entities.MM_ERRORS else error
        heading = entities.MM_ERRORS[quantity][0] if quantity in entities.MM_ERRORS else entities.ERRORS[error]
        plots.append(_curves(f"/{root}/{shown}", heading, legend))
        plots.append(_curves(f"/{root}_log10/{quantity}", title))
    return rrb.Grid(*plots, grid_columns=2, name="Errors")


def _bounds(methods: Sequence[Method], errors: str) -> rrb.Grid:
    """Errors, where they are known, and within what they should be: of the methods that tell."""
    shown = [method for method in methods if method in (Method.PAIRWISE, Method.REFINED)]
    plots: list[Any] = []
    for quantity, (title, logarithm, *_) in entities.BOUNDS.items():
        for kind, heading in (("", title), ("_log10", logarithm)):
            contents = [f"/{name}{kind}/{quantity}/{method}" for name in (errors, "bounds") for method in shown]
            plots.append(_curves("/", heading, HIDDEN if plots else rrb.Corner2D.LeftTop, contents))
    return rrb.Grid(*plots, grid_columns=2, name="Bounds")


def _evidence(name: str, shown: Sequence[str]) -> rrb.Grid:
    plots: list[Any] = []
    for quantity in shown:
        axis = rrb.ScalarAxis(range=(0.0, 1.05)) if quantity in entities.SHARES else None
        legend = HIDDEN if plots else rrb.Corner2D.LeftBottom
        plots.append(_curves(f"/evidence/{quantity}", entities.EVIDENCE[quantity], legend, axis_y=axis))
    return rrb.Grid(*plots, grid_columns=2, name=name)


def _support(methods: Sequence[Method]) -> list[str]:
    """What holds a view, as far as the methods look at it."""
    matching = ["inlier_ratio"] if set(methods) != {"icp"} else []
    return ["observability", *(["edges"] if "refined" in methods else []), *matching]


def _turntable() -> rrb.Vertical:
    plots: list[Any] = [_curves(f"/turntable/{name}", title) for name, title in entities.TURNTABLE.items()]
    return rrb.Vertical(*plots, name="Turntable")


def _classes(categories: Sequence[str]) -> rrb.Vertical:
    """What each view shows alone, and all so far together; one legend for both."""
    share = rrb.ScalarAxis(range=(0.0, 1.05))
    alone, fused = ([f"/classification/{path}{name}" for name in categories] for path in ("", "fused/"))
    return rrb.Vertical(
        _curves("/classification", entities.CLASSES["alone"], rrb.Corner2D.LeftBottom, alone, share),
        _curves("/classification/fused", entities.CLASSES["fused"], HIDDEN, fused, share),
        _curves("/classification/entropy", entities.CLASSES["entropy"]),
        row_shares=[4, 4, 2],
        name="Class",
    )


def _timing(methods: Sequence[Method]) -> rrb.Vertical:
    best = methods[-1]
    title = "Time per view [s]" + (", the joint refinement at the end left out" if best == "refined" else "")
    stages = [f"/timing/{stage}/{best}" for stage in STAGES]
    return rrb.Vertical(
        _curves("/timing/total", title, rrb.Corner2D.LeftTop),
        _curves("/timing", f"Time per view and stage, {best} [s]", rrb.Corner2D.LeftTop, stages),
        name="Timing",
    )
