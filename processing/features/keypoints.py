"""Intrinsic shape signatures (ISS): keypoints where the surface spreads unlike along all three axes (thesis 4.1)."""

from dataclasses import dataclass

import numpy as np

from orbitscan.processing.kernels.eigen import symmetric_eigen
from orbitscan.processing.kernels.grid import Grid, build, rows_around
from orbitscan.processing.kernels.moments import moments_around
from orbitscan.recorder.kernels import kernel, over_slices


@dataclass(frozen=True)
class KeypointSettings:
    """Multiples of the working resolution w; no value is in the thesis."""

    salient_radius: float = 4.0
    non_max_radius: float = 1.5
    gamma_21: float = 0.975  # a second eigenvalue above this share of the first: the axes are not told apart
    gamma_32: float = 0.975
    min_neighbours: int = 5
    at_most: int = 2000  # the most salient ones


def detect_keypoints(
    points: np.ndarray, salient_radius: float, non_max_radius: float, settings: KeypointSettings
) -> np.ndarray:
    """Return the indices (K,) of the keypoints among the points (N, 3), most salient first; radii are in metres.

    Saliency is the smallest eigenvalue of the scatter about the point. Zhong, Intrinsic shape signatures (2009), as
    PCL computes it.
    """
    wide, narrow = build(points, salient_radius), build(points, non_max_radius)
    salient, saliency = np.empty(len(points)), np.empty(len(points))
    gammas = settings.gamma_21, settings.gamma_32
    over_slices(_fill_saliency, len(points), wide, gammas, settings.min_neighbours, salient)
    saliency[wide.order] = salient
    largest = np.empty(len(points), np.bool_)
    over_slices(_find_largest, len(points), narrow, saliency[narrow.order], settings.min_neighbours, largest)
    indices = narrow.order[largest]
    return indices[np.lexsort((indices, -saliency[indices]))][: settings.at_most]


@kernel
def _fill_saliency(
    start: int, stop: int, grid: Grid, gammas: tuple[float, float], min_neighbours: int, saliency: np.ndarray
) -> None:
    """Fill the rows [start, stop) of saliency (N,); the grid's cell is the radius."""
    sums, S, vectors = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for i in range(start, stop):
        saliency[i] = 0.0
        if moments_around(grid, i, grid.cell, sums, S) >= min_neighbours:
            e3, e2, e1 = symmetric_eigen(S, vectors)
            if e3 > 0.0 and e2 < gammas[0] * e1 and e3 < gammas[1] * e2:
                saliency[i] = e3


@kernel
def _find_largest(
    start: int, stop: int, grid: Grid, saliency: np.ndarray, min_neighbours: int, largest: np.ndarray
) -> None:
    """Suppress non-maxima: fill the rows [start, stop) of largest (N,), which points are the most salient around.

    The grid's cell is the radius.
    """
    rows = np.empty((9, 2), np.int64)
    for i in range(start, stop):
        largest[i] = False
        if saliency[i] <= 0.0:
            continue
        rows_around(grid, grid.points[i], rows)
        largest[i] = _count_less_salient(grid.points, i, grid.cell, saliency, rows) >= min_neighbours


@kernel
def _count_less_salient(points: np.ndarray, i: int, radius: float, saliency: np.ndarray, rows: np.ndarray) -> int:
    """Count the points in the ball about point i; -1 where one of them is more salient."""
    px, py, pz, own = points[i, 0], points[i, 1], points[i, 2], saliency[i]
    count = 0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
            if x * x + y * y + z * z < radius * radius:
                if saliency[j] > own:
                    return -1
                count += 1
    return count
