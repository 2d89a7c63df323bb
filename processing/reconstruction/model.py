"""The whole object: the placed views merged, statistical outliers removed (thesis 4.4)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree

from orbitscan.processing.kernels.grid import cell_means
from orbitscan.processing.reconstruction.mesh import MeshSettings, reconstruct_mesh
from orbitscan.processing.results.records import Model
from orbitscan.processing.results.status import Method
from orbitscan.processing.surface.preparation import Scale
from orbitscan.recorder import cloud, poses
from orbitscan.recorder.session import View

_MERGE_EVERY = 250_000  # points held before they are merged


@dataclass(frozen=True)
class ModelSettings:
    """The resolution in multiples of the working resolution; the thesis gives none of these."""

    resolution: float = 1.0
    neighbours: int = 20
    deviations: float = 2.0  # points whose neighbours are farther than mean + k standard deviations go
    mesh: MeshSettings = field(default_factory=MeshSettings)


def build_model(
    views: Iterable[View],
    T_0: Mapping[int, np.ndarray],
    method: Method | None,
    scale: Scale | None,
    sensor_origin: tuple[float, ...] | None,
    settings: ModelSettings,
) -> Model | None:
    """Build the model of the views that a method placed (T_0_i by view); None without any."""
    if scale is None or method is None or not T_0:
        return None
    resolution = settings.resolution * scale.working
    merged = merge(views, T_0, sensor_origin, resolution)
    kept = find_inliers(merged[:, :3], settings)
    rows, removed = merged[kept], merged[~kept, :3].astype(np.float32)
    points, towards = rows[:, :3], rows[:, 3:6]
    colors = np.rint(rows[:, 6:9]).astype(np.uint8) if rows.shape[1] >= 9 else None
    mesh = reconstruct_mesh(points, towards, colors, resolution, settings.mesh) if settings.mesh.wanted else None
    return Model(method, points.astype(np.float32), colors, removed, mesh)


def merge(
    views: Iterable[View], T_0: Mapping[int, np.ndarray], sensor_origin: tuple[float, ...] | None, resolution: float
) -> np.ndarray:
    """Merge the views that have a pose T_0_i to one point in a cell [m], each with the direction it was seen from.

    (N, 6), or (N, 9) with red, green, blue, where every view has them. Where the sensor's place is unknown, a point was
    seen from outside its view's centroid.
    """
    merged: list[np.ndarray] = []
    for view in views:
        if view.index not in T_0:
            continue
        points, colors = cloud.finite(view.points, view.colors)
        if not len(points):
            continue
        towards = points - points.mean(axis=0) if sensor_origin is None else np.array(sensor_origin) - points
        towards /= np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 1e-12)
        T = T_0[view.index]
        attributes = [poses.rotate(T, towards)]
        attributes += [] if colors is None else [colors]
        merged.append(cell_means(poses.transform(T, points), resolution, np.hstack(attributes)))
        if sum(map(len, merged)) > _MERGE_EVERY:
            merged = [_join(merged, resolution)]
    return _join(merged, resolution)


def find_inliers(points: np.ndarray, settings: ModelSettings) -> np.ndarray:
    """Tell which points (N, 3) are no farther from their neighbours than mean + k deviations (4.4): (N,) bool."""
    if len(points) <= settings.neighbours:
        return np.ones(len(points), bool)
    distances, _ = cKDTree(points).query(points, settings.neighbours + 1, workers=get_num_threads())
    apart = distances[:, 1:].mean(axis=1)  # the nearest is the point itself
    return apart <= apart.mean() + settings.deviations * apart.std()


def _join(clouds: list[np.ndarray], resolution: float) -> np.ndarray:
    width = min((rows.shape[1] for rows in clouds), default=6)
    rows = np.concatenate([rows[:, :width] for rows in clouds]) if clouds else np.empty((0, 6))
    return cell_means(rows[:, :3], resolution, rows[:, 3:])
