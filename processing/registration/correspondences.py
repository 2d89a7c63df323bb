"""Partners: for a surfel of one view, the nearest one of another that faces the same way."""

from dataclasses import dataclass

import numpy as np

from orbitscan.processing.kernels.grid import Cells, Grid, build, rows_around
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder.kernels import kernel, over_slices

_FEW = 2000  # points for whose partners it is not worth to start threads
_NORMAL_COSINE = 0.5  # surfaces that face apart by more than 60 degrees are not partners


@dataclass(frozen=True, eq=False)
class Target:
    """Surfels in the cells of a grid, to find partners among."""

    grid: Grid  # holds the points
    normals: np.ndarray  # (S, 3), in the grid's order
    variances: np.ndarray  # (S,)


def make_target(surfels: Surfels, gate: float) -> Target:
    """The surfels in cells as large as the gate [m], the farthest a partner is looked for."""
    grid = build(surfels.points, gate)
    return Target(grid, np.ascontiguousarray(surfels.normals[grid.order]), surfels.variances[grid.order])


def find_partners(points: np.ndarray, normals: np.ndarray, target: Target, gate: float) -> np.ndarray:
    """For points (N, 3) with normals in the target's frame, the position in the target's grid of each one's partner.

    The nearest surfel within the gate [m] that faces the same way; -1 where there is none. (N,) int.
    """
    grid = target.grid
    found = np.empty(len(points), np.int64)
    arguments = (points, normals, grid.points, target.normals, grid.cells, grid.low, grid.cell, gate, found)
    if len(points) < _FEW:
        _partners(0, len(points), *arguments)
    else:
        over_slices(_partners, len(points), *arguments)
    return found


@kernel
def nearest_partner(
    partners: np.ndarray,
    partner_normals: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    p: np.ndarray,
    normal: np.ndarray,
    gate: float,
    rows: np.ndarray,
) -> int:
    """The nearest partner within the gate that faces as the point p (3,) does; -1 where there is none."""
    rows_around(cells, low, cell, p, rows)
    nearest, squared = -1, gate * gate
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = partners[j, 0] - p[0], partners[j, 1] - p[1], partners[j, 2] - p[2]
            far = x * x + y * y + z * z
            if far < squared:
                other = partner_normals[j]
                if normal[0] * other[0] + normal[1] * other[1] + normal[2] * other[2] > _NORMAL_COSINE:
                    nearest, squared = j, far
    return nearest


@kernel
def _partners(
    start: int,
    stop: int,
    points: np.ndarray,
    normals: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    gate: float,
    found: np.ndarray,
) -> None:
    rows = np.empty((9, 2), np.int64)
    for i in range(start, stop):
        found[i] = nearest_partner(partners, partner_normals, cells, low, cell, points[i], normals[i], gate, rows)
