"""Correspondences of surfels: for each one of a view, the nearest of another view that faces the same way."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from orbitscan.processing.kernels.grid import Grid, build, rows_around
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder.kernels import kernel, over_slices

_SERIAL_BELOW = 2000  # points, for fewer of which threads cost more than they save
_NORMAL_COSINE = 0.5  # surfaces that face apart by more than 60 degrees do not correspond


class Target(NamedTuple):
    """Surfels in the cells of a grid, to find correspondences among."""

    grid: Grid  # holds the points
    normals: np.ndarray  # (S, 3), in the grid's order
    variances: np.ndarray  # (S,)


def make_target(surfels: Surfels, gate: float) -> Target:
    """Sort surfels into cells as large as the gate [m], the farthest a correspondence is looked for."""
    grid = build(surfels.points, gate)
    return Target(grid, np.ascontiguousarray(surfels.normals[grid.order]), surfels.variances[grid.order])


def find_correspondences(points: np.ndarray, normals: np.ndarray, target: Target, gate: float) -> np.ndarray:
    """Find the surfel that corresponds to each of the points (N, 3) with normals (N, 3), both in the target's frame.

    It is the nearest one within the gate [m] that faces the same way. Returns its position in the target's grid, -1
    where there is none: (N,) int.
    """
    found = np.empty(len(points), np.int64)
    over_points(_fill_nearest, len(points), points, normals, target, gate, found)
    return found


def over_points(function: Callable[..., None], count: int, *arguments: Any) -> None:
    """Call a kernel for so many points, as `over_slices` does where there are enough to share."""
    if count < _SERIAL_BELOW:
        function(0, count, *arguments)
    else:
        over_slices(function, count, *arguments)


@kernel
def nearest_surfel(target: Target, p: np.ndarray, normal: np.ndarray, gate: float, rows: np.ndarray) -> int:
    """Return the position of the target's surfel nearest to p (3,) within the gate [m] that faces as its normal (3,).

    -1 where there is none. The rows (9, 2) are overwritten.
    """
    rows_around(target.grid, p, rows)
    points, normals = target.grid.points, target.normals
    nearest, squared = -1, gate * gate
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - p[0], points[j, 1] - p[1], points[j, 2] - p[2]
            far = x * x + y * y + z * z
            if far < squared:
                other = normals[j]
                if normal[0] * other[0] + normal[1] * other[1] + normal[2] * other[2] > _NORMAL_COSINE:
                    nearest, squared = j, far
    return nearest


@kernel
def _fill_nearest(
    start: int, stop: int, points: np.ndarray, normals: np.ndarray, target: Target, gate: float, found: np.ndarray
) -> None:
    """Fill the rows [start, stop) of found (N,), the surfels nearest to points (N, 3) with normals (N, 3)."""
    rows = np.empty((9, 2), np.int64)
    for i in range(start, stop):
        found[i] = nearest_surfel(target, points[i], normals[i], gate, rows)
