"""Surface normals by principal components of the neighbourhood."""

import numpy as np
from numba import njit, prange

from processing.features.eigen import symmetric_eigen
from processing.features.grid import build, rows_around

MIN_NEIGHBOURS = 3


def estimate_normals(points: np.ndarray, radius: float, sensor_origin: np.ndarray | None) -> np.ndarray:
    """Unit normals (N, 3) of points (N, 3); NaN where there are fewer than three neighbours.

    The neighbourhood is a ball [m] about each point. Normals face the sensor (3,), or away from the cloud's centroid
    where its place is unknown (None).
    """
    grid = build(points, radius)
    away = sensor_origin is None
    towards = grid.points.mean(axis=0) if away else np.asarray(sensor_origin, dtype=np.float64)
    normals = np.empty_like(grid.points)
    normals[grid.order] = _normals(grid.points, grid.keys, grid.low, grid.cell, float(radius), towards, away)
    return normals


@njit(parallel=True, cache=True)
def _normals(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    radius: float,
    towards: np.ndarray,
    away: bool,
) -> np.ndarray:
    normals = np.empty_like(points)
    for i in prange(len(points)):
        _fill_normal(points, keys, low, cell, i, radius, towards, away, normals[i])
    return normals


@njit(cache=True)
def _fill_normal(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    i: int,
    radius: float,
    towards: np.ndarray,
    away: bool,
    normal: np.ndarray,
) -> None:
    """Fill the normal (3,) of point i."""
    rows = np.empty((9, 2), np.int64)
    p = points[i]
    rows_around(keys, low, cell, p, rows)
    count = 0
    sx = sy = sz = sxx = sxy = sxz = syy = syz = szz = 0.0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - p[0], points[j, 1] - p[1], points[j, 2] - p[2]
            if x * x + y * y + z * z < radius * radius:
                count += 1
                sx += x
                sy += y
                sz += z
                sxx += x * x
                sxy += x * y
                sxz += x * z
                syy += y * y
                syz += y * z
                szz += z * z
    if count < MIN_NEIGHBOURS:
        normal[:] = np.nan
        return
    cxx, cyy, czz = sxx - sx * sx / count, syy - sy * sy / count, szz - sz * sz / count
    cxy, cxz, cyz = sxy - sx * sy / count, sxz - sx * sz / count, syz - sy * sz / count
    C = np.array([[cxx, cxy, cxz], [cxy, cyy, cyz], [cxz, cyz, czz]])
    vectors = np.empty((3, 3))
    symmetric_eigen(C, vectors)
    facing = 0.0
    for k in range(3):
        facing += vectors[k, 0] * (towards[k] - p[k])
    flip = (facing < 0.0) != away
    for k in range(3):
        normal[k] = -vectors[k, 0] if flip else vectors[k, 0]
