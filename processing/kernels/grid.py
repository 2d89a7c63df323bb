"""Points sorted into cells, so that kernels walk a neighbourhood without neighbour lists or a tree."""

from typing import NamedTuple

import numpy as np

from orbitscan.recorder.kernels import kernel

_MOST = 1024  # columns along x and along y; points beyond stand in the outermost ones
_SPREAD = 1 << 20  # cells along an axis, at most, where three indices make one number


class Grid(NamedTuple):
    """Points in the order of their cells: column by column along x and y, upwards along z in each."""

    points: np.ndarray  # (N, 3) float64, sorted
    order: np.ndarray  # (N,) int64: sorted position -> original index
    columns: np.ndarray  # (X, Y, 2) int64: slices [start, stop) of the sorted points
    levels: np.ndarray  # (N,) int64: z indices of the sorted points
    low: np.ndarray  # (3,) the lower corner [m]
    cell: float  # side of a cell [m]


def build(points: np.ndarray, cell: float) -> Grid:
    """Sort points (N, 3) into a grid with cells of a side [m]; a search radius may not exceed it."""
    points = np.ascontiguousarray(points, dtype=np.float64)
    cell = float(cell)
    low = points.min(axis=0) if len(points) else np.zeros(3)
    high = points.max(axis=0) if len(points) else np.zeros(3)
    for k in range(2):  # a stray point far off may not make the columns many
        if high[k] - low[k] > _MOST * cell:
            low[k] = np.median(points[:, k]) - _MOST / 2 * cell
    counts = np.minimum((high - low)[:2] / cell, _MOST - 1).astype(np.int64) + 1
    x, y = np.clip(np.floor((points[:, :2] - low[:2]) / cell), 0, counts - 1).astype(np.int64).T
    levels = ((points[:, 2] - low[2]) / cell).astype(np.int64)
    column = x * counts[1] + y
    order = np.lexsort((levels, column))
    bounds = np.searchsorted(column[order], np.arange(counts.prod() + 1))
    columns = np.stack([bounds[:-1], bounds[1:]], axis=1).reshape(*counts, 2)
    return Grid(points[order], order, columns, levels[order], low, cell)


def cell_means(points: np.ndarray, cell: float, attributes: np.ndarray | None = None) -> np.ndarray:
    """Return the mean of each cell's points (N, 3) and of their attributes (N, A): (M, 3 + A), in the cells' order."""
    if not len(points):
        return np.empty((0, 3 if attributes is None else 3 + attributes.shape[1]))
    points = np.asarray(points, dtype=np.float64)
    low = points.min(axis=0)
    cell = max(cell, float((points.max(axis=0) - low).max()) / (_SPREAD - 1))
    x, y, z = ((points - low) / cell).astype(np.int64).T
    keys = (x * _SPREAD + y) * _SPREAD + z
    order = np.argsort(keys, kind="stable")
    rows = points[order] if attributes is None else np.hstack([points[order], attributes[order]])
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    return np.add.reduceat(rows, starts, axis=0) / np.diff(starts, append=len(rows))[:, None]


@kernel
def rows_around(grid: Grid, point: np.ndarray, rows: np.ndarray) -> None:
    """Fill rows (9, 2) with the slices [start, stop) of the sorted points in the 27 cells around a point."""
    columns, levels, low, cell = grid.columns, grid.levels, grid.low, grid.cell
    width, height, _ = columns.shape
    x = min(max(int(np.floor((point[0] - low[0]) / cell)), 0), width - 1)
    y = min(max(int(np.floor((point[1] - low[1]) / cell)), 0), height - 1)
    z = int(np.floor((point[2] - low[2]) / cell))
    row = 0
    for i in range(x - 1, x + 2):
        for j in range(y - 1, y + 2):
            rows[row, 0] = rows[row, 1] = 0
            if 0 <= i < width and 0 <= j < height:
                start, stop = columns[i, j, 0], columns[i, j, 1]
                rows[row, 0] = _first_at_least(levels, z - 1, start, stop)
                rows[row, 1] = _first_at_least(levels, z + 2, rows[row, 0], stop)
            row += 1


@kernel
def _first_at_least(levels: np.ndarray, level: int, start: int, stop: int) -> int:
    """The first position from start to stop whose level is not smaller."""
    while start < stop:
        middle = (start + stop) // 2
        if levels[middle] < level:
            start = middle + 1
        else:
            stop = middle
    return start
