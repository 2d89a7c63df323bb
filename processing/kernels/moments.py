"""Moments of a neighbourhood, from which normals and saliency are read."""

import numpy as np

from orbitscan.processing.kernels.grid import Grid, rows_around
from orbitscan.recorder.kernels import kernel


@kernel
def moments_around(grid: Grid, i: int, radius: float, first: np.ndarray, second: np.ndarray) -> int:
    """Count the points within the radius [m] of the grid's i-th, itself among them.

    Fill first (3,) and second (3, 3) with the sums of d and of d d^t, d being their offsets from the i-th.
    """
    points = grid.points
    rows = np.empty((9, 2), np.int64)
    px, py, pz = points[i, 0], points[i, 1], points[i, 2]
    rows_around(grid, points[i], rows)
    count = 0
    sx = sy = sz = sxx = sxy = sxz = syy = syz = szz = 0.0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
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
    first[0], first[1], first[2] = sx, sy, sz
    second[0, 0], second[0, 1], second[0, 2] = sxx, sxy, sxz
    second[1, 0], second[1, 1], second[1, 2] = sxy, syy, syz
    second[2, 0], second[2, 1], second[2, 2] = sxz, syz, szz
    return count
