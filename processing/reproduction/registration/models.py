"""Figure 5.9: the models that the methods make of each object, from six sides, and how far off its surface they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from orbitscan.processing.reconstruction.model import build_model
from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import Claim, compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.run import OBJECTS, THESIS, Run, run_all
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.runs import digest
from orbitscan.processing.results.status import Method
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import choose_scale
from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.atomic import whole_file
from orbitscan.recorder.formats import ply
from orbitscan.recorder.libraries import load_open3d
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation import objects

SHOWN = (*THESIS, "refined")  # the thesis's two, and ours
SIDES = {  # name -> azimuth from the front (+x) counterclockwise seen from above, elevation [degrees]
    "front": (0, 0),
    "left": (90, 0),
    "rear": (180, 0),
    "right": (270, 0),
    "top": (0, 90),
    "bird's view": (35, 35),
}
_DRAWN = 30_000  # points of a model
_GREY = 0.45  # brightness of points without colour
_FADE = 0.45  # how much the farthest point is lighter than the nearest


@dataclass(frozen=True, eq=False)
class Placed:
    """A model in the frame of its object, and how far it is off."""

    run: Run
    points: np.ndarray  # (N, 3) [m]
    colors: np.ndarray | None  # (N, 3) uint8
    off_mm: np.ndarray  # (N,) from the true surface

    @property
    def off_95_mm(self) -> float:
        """The distance from the true surface within which 95 % of the points lie [mm]."""
        return float(np.percentile(self.off_mm, 95))


def show_models(plan: Plan) -> Report:
    """Pictures of the first run's models; a row for each model of every run."""
    runs = [run for run in run_all(plan) if run.method in SHOWN and not run.circle.dense]
    placed = [_place(plan, run) for run in runs]
    figures = {
        f"figure-5.9-{what}": _draw([p for p in placed if p.run.circle.what == what and p.run.circle.seed == 0])
        for what in OBJECTS
    }
    rows = [_describe(model) for model in placed]
    return Report("figure-5.9", "The models from six sides", rows, [_rank(placed)], _claim(placed), figures)


def _place(plan: Plan, run: Run) -> Placed:
    """Build the model of a run, and move it to the object's frame: the truth serves to look at it and to judge it."""
    recording = mcap_file.read(plan.folder / "circles" / f"{run.circle.name}.mcap")
    path = plan.folder / "models" / f"{run.circle.name}-{run.method}-{digest(run.key)}.ply"
    if not path.exists():
        _build(recording, run, path)
    points, colors = ply.read(path)
    points = poses.transform(recording.truth()[run.views[0]["view"]], points)
    return Placed(run, points, colors, 1000 * _distances(run.circle.what, points))


def _build(recording: Session, run: Run, path: Path) -> None:
    """Write the model of all views that have an estimate, as in the thesis; `process` takes those that are ok."""
    settings, views = Settings(), recording.views()
    scale, origin = choose_scale(views, settings.surface), recording.info.sensor_origin
    model = build_model(views, run.poses, Method(run.method), scale, origin, settings.model)
    assert model is not None, f"{path.name}: no view was placed"
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part:
        ply.write(part, model.points, model.colors)


def _distances(what: str, points: np.ndarray) -> np.ndarray:
    """How far points (N, 3) are from an object's surface [m]."""
    o3d = load_open3d("make the other figures")
    mesh = objects.build(what, 1)
    scene = o3d.t.geometry.RaycastingScene()
    vertices, triangles = mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)
    scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(triangles))
    return scene.compute_distance(o3d.core.Tensor(points.astype(np.float32))).numpy()


def _describe(model: Placed) -> Row:
    return {
        "object": model.run.circle.what,
        "method": model.run.method,
        "run": model.run.circle.seed,
        "views": len(model.run.poses),
        "points": len(model.points),
        "median_off_mm": float(np.median(model.off_mm)),
        "off_95_percent_mm": model.off_95_mm,
    }


def _claim(models: Sequence[Placed]) -> list[Claim]:
    """Whether the model after RANSAC lies closer to the true surface, object by object."""
    claims = []
    for what in OBJECTS:
        icp, ransac = (
            [model.off_95_mm for model in models if (model.run.circle.what, model.run.method) == (what, method)]
            for method in THESIS
        )
        text = f"RANSAC before ICP brings 95 % of the model of the {what.replace('_', ' ')} closer to its surface"
        claims.append(compare(text, icp, ransac, "mm"))
    return claims


def _rank(models: Sequence[Placed]) -> str:
    """How far off the surface the models of each method are, on average."""
    means = {method: np.mean([model.off_95_mm for model in models if model.run.method == method]) for method in SHOWN}
    said = ", ".join(f"{method} {mean:.2f} mm" for method, mean in means.items())
    return f"95 % of a model's points lie within, mean of objects and runs: {said} of the true surface."


def _draw(models: Sequence[Placed]) -> charts.Figure:
    """A figure with a row for each model and a column for each side."""
    figure, rows = charts.new_figure(len(models), len(SIDES), width=10, height=1.75 * len(models) + 0.2, dpi=90)
    half = 0.55 * max(float(np.ptp(model.points, axis=0).max()) for model in models)
    for i, (line, model) in enumerate(zip(rows, models, strict=True)):
        step = -(-len(model.points) // _DRAWN)
        for axes, side in zip(line, SIDES, strict=True):
            colors = None if model.colors is None else model.colors[::step]
            _draw_cloud(axes, model.points[::step], side, half, colors)
            if i == 0:
                axes.set_title(side, fontsize=9)
        charts.name_row(line[0], -0.04, model.run.method, fontsize=9)
    return figure


def _draw_cloud(axes: Axes, points: np.ndarray, side: str, half: float, colors: np.ndarray | None = None) -> None:
    """Draw points (N, 3) [m] from one of SIDES without perspective, far ones lighter and behind.

    The picture is 2 `half` [m] wide and high; colors (N, 3) are uint8.
    """
    right, up, toward = _directions(*SIDES[side])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    relative = points - middle
    depth = relative @ toward
    order = np.argsort(depth)
    share = (depth - depth.min()) / max(np.ptp(depth), 1e-9)  # 0: the farthest
    own = np.full((len(points), 3), _GREY) if colors is None else colors / 255
    shaded = own + (1 - own) * (_FADE * (1 - share))[:, None]
    across, along = (relative @ right)[order], (relative @ up)[order]
    axes.scatter(across, along, s=2.4, c=shaded[order], linewidths=0, rasterized=True)
    axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    axes.set_axis_off()


def _directions(azimuth_deg: float, elevation_deg: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors to the right and up in the picture, and towards whoever looks."""
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    toward = np.cos(elevation) * level + np.array([0, 0, np.sin(elevation)])
    return right, np.cross(toward, right), toward
