"""Points sorted into cells, so that kernels walk a neighbourhood without neighbour lists or a tree."""

from dataclasses import dataclass

import numpy as np

from processing.features.parallel import kernel

_SPREAD = 1 << 20  # cells along an axis, at most: three coordinates fit one int64 key


@dataclass(frozen=True, eq=False)
class Grid:
    """Points in the order of their cells; a row of three cells along z is one contiguous slice."""

    points: np.ndarray  # (N, 3) float64, sorted by key
    order: np.ndarray  # (N,) int64: sorted position -> original index
    keys: np.ndarray  # (N,) int64, ascending
    low: np.ndarray  # (3,) the lower corner
    cell: float


def build(points: np.ndarray, cell: float) -> Grid:
    """The grid of points (N, 3) with cells of a side [m]; a search radius may not exceed it."""
    points = np.ascontiguousarray(points, dtype=np.float64)
    low = points.min(axis=0) - cell if len(points) else np.zeros(3)
    high = points.max(axis=0) if len(points) else np.zeros(3)
    cell = max(float(cell), float((high - low).max()) / (_SPREAD - 2))
    indices = ((points - low) / cell).astype(np.int64)
    keys = (indices[:, 0] * _SPREAD + indices[:, 1]) * _SPREAD + indices[:, 2]
    order = np.argsort(keys, kind="stable")
    return Grid(points[order], order, keys[order], low, cell)


def cell_means(points: np.ndarray, cell: float, attributes: np.ndarray | None = None) -> np.ndarray:
    """One row a cell, the mean of its points (N, 3) and of their attributes (N, A), (M, 3 + A), in the cells' order."""
    if not len(points):
        return np.empty((0, 3 if attributes is None else 3 + attributes.shape[1]))
    grid = build(points, cell)
    rows = grid.points if attributes is None else np.hstack([grid.points, attributes[grid.order]])
    starts = np.flatnonzero(np.diff(grid.keys, prepend=-1))
    return np.add.reduceat(rows, starts, axis=0) / np.diff(starts, append=len(rows))[:, None]


@kernel
def first_at_least(keys: np.ndarray, key: int) -> int:
    """The first position whose key is not smaller."""
    low, high = 0, len(keys)
    while low < high:
        middle = (low + high) // 2
        if keys[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low


@kernel
def rows_around(keys: np.ndarray, low: np.ndarray, cell: float, point: np.ndarray, rows: np.ndarray) -> None:
    """Fill rows (9, 2) with the slices [start, stop) of the sorted points in the 27 cells around a point."""
    x = int((point[0] - low[0]) / cell)
    y = int((point[1] - low[1]) / cell)
    z = int((point[2] - low[2]) / cell)
    row = 0
    for i in range(x - 1, x + 2):
        for j in range(y - 1, y + 2):
            key = (i * _SPREAD + j) * _SPREAD + z
            rows[row, 0] = first_at_least(keys, key - 1)
            rows[row, 1] = first_at_least(keys, key + 2)
            row += 1
