"""Figure 5.9: the models that the methods make of each object, from six sides, and how far off its surface they are."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.reconstruction.model import build_model
from orbitscan.processing.reproduction.claims import compare
from orbitscan.processing.reproduction.drawing import charts
from orbitscan.processing.reproduction.drawing.clouds import SIDES, draw_cloud
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.run import OBJECTS, Run, run_all
from orbitscan.processing.reproduction.report import Report
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import choose_scale
from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.atomic import whole_file
from orbitscan.recorder.formats import ply
from orbitscan.recorder.libraries import load_open3d
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation import objects

SHOWN = ("icp", "ransac_icp", "refined")  # the thesis's two, and ours
_DRAWN = 30_000  # points of a model


@dataclass(frozen=True, eq=False)
class Placed:
    """A model in its object's frame."""

    run: Run
    points: np.ndarray  # (N, 3) [m]
    colors: np.ndarray | None  # (N, 3) uint8
    off_mm: np.ndarray  # (N,) from the true surface


def show_models(plan: Plan) -> Report:
    """Pictures of the first run's models; a row for each model of every run."""
    runs = [run for run in run_all(plan) if run.method in SHOWN and not run.circle.dense]
    placed = [_place(plan, run) for run in runs]
    figures = {
        f"figure-5.9-{what}": _draw([p for p in placed if p.run.circle.what == what and p.run.circle.seed == 0])
        for what in OBJECTS
    }
    rows = [_describe(model) for model in placed]
    return Report("figure-5.9", "The models from six sides", rows, [*_claim(rows), _rank(rows)], figures)


def _place(plan: Plan, run: Run) -> Placed:
    """A model moved from the first camera's frame to the object's: the truth serves to look at it and to judge it."""
    recording = mcap_file.read(plan.folder / "circles" / f"{run.circle.name}.mcap")
    digest = hashlib.sha256(json.dumps(run.key, sort_keys=True).encode()).hexdigest()
    path = plan.folder / "models" / f"{run.circle.name}-{run.method}-{digest[:12]}.ply"
    if not path.exists():
        _build(recording, run, path)
    points, colors = ply.read(path)
    points = poses.transform(recording.truth()[run.views[0]["view"]], points)
    return Placed(run, points, colors, 1000 * _distances(run.circle.what, points))


def _build(recording: Session, run: Run, path: Path) -> None:
    """Merge all views that have an estimate, as the thesis does; a results folder's model has those that are ok."""
    settings, views = Settings(), recording.views()
    model = build_model(
        views,
        run.poses,
        run.method,
        choose_scale(views, settings.surface),
        recording.info.sensor_origin,
        settings.model,
    )
    with whole_file(path) as part:
        ply.write(part, model.points, model.colors)


def _distances(what: str, points: np.ndarray) -> np.ndarray:
    """How far points (N, 3) are from an object's surface [m]."""
    o3d = load_open3d("make the other figures")
    mesh = objects.build(what, 1)
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor(mesh.vertices.astype(np.float32)), o3d.core.Tensor(mesh.triangles.astype(np.uint32))
    )
    return scene.compute_distance(o3d.core.Tensor(points.astype(np.float32))).numpy()


def _describe(model: Placed) -> dict[str, Any]:
    return {
        "object": model.run.circle.what,
        "method": model.run.method,
        "run": model.run.circle.seed,
        "views": len(model.run.poses),
        "points": len(model.points),
        "median_off_mm": float(np.median(model.off_mm)),
        "off_95_percent_mm": float(np.percentile(model.off_mm, 95)),
    }


def _claim(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Whether the model after RANSAC lies closer to the true surface, object by object."""
    said = []
    for what in OBJECTS:
        icp, ransac = (
            [row["off_95_percent_mm"] for row in rows if row["object"] == what and row["method"] == method]
            for method in SHOWN[:2]
        )
        text = f"RANSAC before ICP brings 95 % of the model of the {what.replace('_', ' ')} closer to its surface"
        said.append(str(compare(text, icp, ransac, "mm")))
    return said


def _rank(rows: Sequence[Mapping[str, Any]]) -> str:
    means = {method: np.mean([row["off_95_percent_mm"] for row in rows if row["method"] == method]) for method in SHOWN}
    said = ", ".join(f"{method} {mean:.2f} mm" for method, mean in means.items())
    return f"95 % of a model's points lie within, mean of objects and runs: {said} of the true surface."


def _draw(models: Sequence[Placed]) -> charts.Figure:
    """A row for each method, a column for each side."""
    figure, rows = charts.new_figure(len(models), len(SIDES), width=10, height=1.75 * len(models) + 0.2, dpi=90)
    half = 0.55 * max(float(np.ptp(model.points, axis=0).max()) for model in models)
    for i, (line, model) in enumerate(zip(rows, models, strict=True)):
        step = -(-len(model.points) // _DRAWN)
        for axes, side in zip(line, SIDES, strict=True):
            colors = None if model.colors is None else model.colors[::step]
            draw_cloud(axes, model.points[::step], side, half, colors)
            if i == 0:
                axes.set_title(side, fontsize=9)
        line[0].text(
            -0.04, 0.5, model.run.method, transform=line[0].transAxes, rotation=90, ha="right", va="center", fontsize=9
        )
    return figure
