"""Surface normals by principal components of the neighbourhood."""

import numpy as np

from orbitscan.processing.kernels.eigen import symmetric_eigen
from orbitscan.processing.kernels.grid import Grid, build
from orbitscan.processing.kernels.moments import moments_around
from orbitscan.recorder.kernels import kernel, over_slices

MIN_NEIGHBOURS = 3


def estimate_normals(points: np.ndarray, radius: float, sensor_origin: np.ndarray | None) -> np.ndarray:
    """Estimate unit normals (N, 3) of points (N, 3); NaN where there are fewer than three neighbours.

    The neighbourhood is a ball [m] about each point. Normals face the sensor (3,), or away from the cloud's centroid
    where its place is unknown (None).
    """
    grid = build(points, radius)
    away = sensor_origin is None
    towards = grid.points.mean(axis=0) if away else np.asarray(sensor_origin, dtype=np.float64)
    found, normals = np.empty_like(grid.points), np.empty_like(grid.points)
    over_slices(_fill_normals, len(points), grid, towards, away, found)
    normals[grid.order] = found
    return normals


@kernel
def _fill_normals(start: int, stop: int, grid: Grid, towards: np.ndarray, away: bool, normals: np.ndarray) -> None:
    """Fill the rows [start, stop) of normals (N, 3); the grid's cell is the radius."""
    points = grid.points
    sums, C, vectors = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for i in range(start, stop):
        count = moments_around(grid, i, grid.cell, sums, C)
        if count < MIN_NEIGHBOURS:
            for k in range(3):
                normals[i, k] = np.nan
            continue
        for j in range(3):
            for k in range(3):
                C[j, k] -= sums[j] * sums[k] / count
        symmetric_eigen(C, vectors)
        facing = 0.0
        for k in range(3):
            facing += vectors[k, 0] * (towards[k] - points[i, k])
        flip = (facing < 0.0) != away
        for k in range(3):
            normals[i, k] = -vectors[k, 0] if flip else vectors[k, 0]
