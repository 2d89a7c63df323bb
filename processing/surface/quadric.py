"""Quadrics fitted to a surface's neighbourhoods: denoised points, their normals, and how well they are known."""

import numpy as np

from orbitscan.processing.kernels.cholesky import solve
from orbitscan.processing.kernels.grid import Grid, build, rows_around
from orbitscan.recorder.kernels import kernel, over_slices

TERMS = 6  # 1, x, y, x^2, x y, y^2
MIN_NEIGHBOURS = 10  # some more than terms, or there is nothing left to tell the variance by
_RIDGE = 1e-6  # of the weights' sum: keeps points along a line solvable


def fit_quadrics(
    points: np.ndarray, normals: np.ndarray, cloud: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit quadrics to a cloud (N, 3) at points (M, 3): points (M, 3), unit normals (M, 3) and variances (M,) [m^2].

    In the tangent frame of each point, whose normal is known roughly, z = a + b x + c y + d x^2 + e x y + f y^2 is
    fitted to the cloud within the radius [m], weighed by (1 - (r / radius)^2)^2: the point moves along its normal onto
    the quadric and takes the quadric's normal there. The variance is that of the cloud's points about the quadric: the
    noise where the surface is smooth, more at creases. NaN where there is no normal or fewer than ten neighbours.
    A quadric, because a plane moves points to the inside of every curve (Levin, Mesh-independent surface interpolation,
    2003).
    """
    grid = build(cloud, radius)
    fitted = np.array(points, dtype=np.float64)
    turned = np.array(normals, dtype=np.float64)
    variances = np.full(len(fitted), np.nan)
    over_slices(_fit, len(fitted), grid, fitted, turned, variances)
    return fitted, turned, variances


@kernel
def _fit(start: int, stop: int, grid: Grid, points: np.ndarray, normals: np.ndarray, variances: np.ndarray) -> None:
    """Overwrite points and normals [start, stop) by the quadrics', and fill their variances."""
    for i in range(start, stop):
        variances[i] = _fit_one(grid, points[i], normals[i])


@kernel
def _fit_one(grid: Grid, p: np.ndarray, normal: np.ndarray) -> float:
    """Overwrite p and normal (3,) by the quadric's and return the variance [m^2] about it; NaN where there is none.

    The grid holds the cloud; its cell is the radius.
    """
    cloud, radius = grid.points, grid.cell
    if np.isnan(normal[0]):
        return np.nan
    rows = np.empty((9, 2), np.int64)
    A = np.zeros((TERMS, TERMS))
    b = np.zeros(TERMS)
    f = np.empty(TERMS)
    u, v = np.empty(3), np.empty(3)
    _fill_tangents(normal, u, v)
    rows_around(grid, p, rows)
    count, weights, squares = 0, 0.0, 0.0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            dx, dy, dz = (cloud[j, 0] - p[0]) / radius, (cloud[j, 1] - p[1]) / radius, (cloud[j, 2] - p[2]) / radius
            far = dx * dx + dy * dy + dz * dz
            if far >= 1.0:
                continue
            weight = (1.0 - far) * (1.0 - far)
            x = dx * u[0] + dy * u[1] + dz * u[2]
            y = dx * v[0] + dy * v[1] + dz * v[2]
            z = dx * normal[0] + dy * normal[1] + dz * normal[2]
            f[0], f[1], f[2], f[3], f[4], f[5] = 1.0, x, y, x * x, x * y, y * y
            for a in range(TERMS):
                b[a] += weight * f[a] * z
                for c in range(a + 1):
                    A[a, c] += weight * f[a] * f[c]
            count += 1
            weights += weight
            squares += weight * z * z
    if count < MIN_NEIGHBOURS:
        return np.nan
    for a in range(TERMS):
        A[a, a] += _RIDGE * weights
        f[a] = b[a]
    if not solve(A, b):
        return np.nan
    for a in range(TERMS):
        squares -= b[a] * f[a]
    length = np.sqrt(1.0 + b[1] * b[1] + b[2] * b[2])
    for k in range(3):
        p[k] += b[0] * radius * normal[k]
        normal[k] = (normal[k] - b[1] * u[k] - b[2] * v[k]) / length
    return max(squares, 0.0) / weights * count / (count - TERMS) * radius * radius


@kernel
def _fill_tangents(normal: np.ndarray, u: np.ndarray, v: np.ndarray) -> None:
    """Fill u and v (3,) with unit vectors across the normal (3,) and each other."""
    least = 0
    for k in range(1, 3):
        if abs(normal[k]) < abs(normal[least]):
            least = k
    length = np.sqrt(1.0 - normal[least] * normal[least])
    for k in range(3):
        u[k] = ((1.0 if k == least else 0.0) - normal[least] * normal[k]) / length
    v[0] = normal[1] * u[2] - normal[2] * u[1]
    v[1] = normal[2] * u[0] - normal[0] * u[2]
    v[2] = normal[0] * u[1] - normal[1] * u[0]
