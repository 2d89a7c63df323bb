"""Intrinsic shape signatures (ISS): keypoints where the surface spreads unlike along all three axes (thesis 4.1)."""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from processing.features.eigen import symmetric_eigen
from processing.features.grid import build, rows_around


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
) -> tuple[np.ndarray, np.ndarray]:
    """(indices, saliency): which of the points (N, 3) are keypoints (K,), most salient first; radii in metres.

    Saliency is the smallest eigenvalue of the scatter about the point. Zhong, Intrinsic shape signatures (2009), as
    PCL computes it.
    """
    wide, narrow = build(points, salient_radius), build(points, non_max_radius)
    saliency = np.empty(len(points))
    saliency[wide.order] = _saliency(
        wide.points,
        wide.keys,
        wide.low,
        wide.cell,
        float(salient_radius),
        settings.gamma_21,
        settings.gamma_32,
        settings.min_neighbours,
    )
    largest = _is_largest(
        narrow.points,
        narrow.keys,
        narrow.low,
        narrow.cell,
        float(non_max_radius),
        saliency[narrow.order],
        settings.min_neighbours,
    )
    indices = narrow.order[largest]
    ranked = indices[np.lexsort((indices, -saliency[indices]))][: settings.at_most]
    return ranked, saliency[ranked]


@njit(parallel=True, cache=True)
def _saliency(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    radius: float,
    gamma_21: float,
    gamma_32: float,
    min_neighbours: int,
) -> np.ndarray:
    saliency = np.zeros(len(points))
    for i in prange(len(points)):
        saliency[i] = _saliency_at(points, keys, low, cell, i, radius, gamma_21, gamma_32, min_neighbours)
    return saliency


@njit(cache=True)
def _saliency_at(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    i: int,
    radius: float,
    gamma_21: float,
    gamma_32: float,
    min_neighbours: int,
) -> float:
    rows = np.empty((9, 2), np.int64)
    p = points[i]
    rows_around(keys, low, cell, p, rows)
    count = 0
    sxx = sxy = sxz = syy = syz = szz = 0.0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - p[0], points[j, 1] - p[1], points[j, 2] - p[2]
            if x * x + y * y + z * z < radius * radius:
                count += 1
                sxx += x * x
                sxy += x * y
                sxz += x * z
                syy += y * y
                syz += y * z
                szz += z * z
    if count < min_neighbours:
        return 0.0
    S = np.array([[sxx, sxy, sxz], [sxy, syy, syz], [sxz, syz, szz]])
    e3, e2, e1 = symmetric_eigen(S, np.empty((3, 3)))
    return e3 if e3 > 0.0 and e2 < gamma_21 * e1 and e3 < gamma_32 * e2 else 0.0


@njit(parallel=True, cache=True)
def _is_largest(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    radius: float,
    saliency: np.ndarray,
    min_neighbours: int,
) -> np.ndarray:
    """Non-maximum suppression: which points are the most salient of their ball."""
    largest = np.zeros(len(points), np.bool_)
    for i in prange(len(points)):
        largest[i] = saliency[i] > 0.0 and _is_largest_at(points, keys, low, cell, i, radius, saliency, min_neighbours)
    return largest


@njit(cache=True)
def _is_largest_at(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    i: int,
    radius: float,
    saliency: np.ndarray,
    min_neighbours: int,
) -> bool:
    rows = np.empty((9, 2), np.int64)
    p = points[i]
    rows_around(keys, low, cell, p, rows)
    count = 0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - p[0], points[j, 1] - p[1], points[j, 2] - p[2]
            if x * x + y * y + z * z < radius * radius:
                if saliency[j] > saliency[i]:
                    return False
                count += 1
    return count >= min_neighbours
