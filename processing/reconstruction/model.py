"""The whole object: the placed views merged, statistical outliers removed (thesis 4.4)."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree

from processing.features.grid import cell_means
from processing.results.records import METHODS, Model
from processing.surface import Scale
from recorder import cloud, poses
from recorder.session import View

_MERGE_EVERY = 2_000_000  # points held before they are merged


@dataclass(frozen=True)
class ModelSettings:
    """The resolution in multiples of the working resolution; the thesis gives none of these."""

    resolution: float = 1.0
    neighbours: int = 20
    deviations: float = 2.0  # points whose neighbours are farther than mean + k standard deviations go


def build_model(
    views: Iterable[View],
    poses_of: Mapping[str, Mapping[int, np.ndarray]],
    scale: Scale | None,
    settings: ModelSettings,
) -> Model | None:
    """The model by the best method run, of the views it placed (method -> view -> T_0_i); None without any."""
    method = next((m for m in reversed(METHODS) if m in poses_of), None)
    if scale is None or method is None or not poses_of[method]:
        return None
    merged = merge(views, poses_of[method], settings.resolution * scale.working)
    return remove_outliers(merged, method, settings)


def merge(views: Iterable[View], T_0: Mapping[int, np.ndarray], resolution: float) -> np.ndarray:
    """The points of the views that have a pose T_0_i, one in a cell [m]: (N, 3), or (N, 6) with red, green, blue.

    Colours only where every view has them.
    """
    merged: list[np.ndarray] = []
    for view in views:
        if view.index not in T_0:
            continue
        points, colors = cloud.finite(view.points, view.colors)
        merged.append(cell_means(poses.transform(T_0[view.index], points), resolution, colors))
        if sum(map(len, merged)) > _MERGE_EVERY:
            merged = [_join(merged, resolution)]
    return _join(merged, resolution)


def _join(clouds: list[np.ndarray], resolution: float) -> np.ndarray:
    width = min((rows.shape[1] for rows in clouds), default=3)
    rows = np.concatenate([rows[:, :width] for rows in clouds]) if clouds else np.empty((0, 3))
    return cell_means(rows[:, :3], resolution, rows[:, 3:])


def remove_outliers(merged: np.ndarray, method: str, settings: ModelSettings) -> Model:
    """The merged rows as a model, without points farther from their neighbours than mean + k standard deviations."""
    points = merged[:, :3]
    kept = np.ones(len(merged), bool)
    if len(merged) > settings.neighbours:
        distances, _ = cKDTree(points).query(points, settings.neighbours + 1, workers=get_num_threads())
        apart = distances[:, 1:].mean(axis=1)  # the nearest is the point itself
        kept = apart <= apart.mean() + settings.deviations * apart.std()
    colors = np.rint(merged[kept, 3:6]).astype(np.uint8) if merged.shape[1] >= 6 else None
    return Model(method, points[kept].astype(np.float32), colors, points[~kept].astype(np.float32))
