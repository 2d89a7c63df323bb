"""The least-squares problem of bringing two surfaces together, linearised: distances along the mean of both normals."""

import numpy as np

from orbitscan.processing.kernels.grid import Cells
from orbitscan.processing.registration.correspondences import Target, nearest_partner
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder.kernels import kernel, over_slices

_CHUNKS = 16  # sums are made in so many parts, whatever the number of threads: the same bits on every machine


def normal_equations(
    source: Surfels,
    target: Target,
    least: float,
    T: np.ndarray,
    center: np.ndarray,
    gate: float,
    slide: float,
    deviations: float,
) -> tuple[np.ndarray, np.ndarray]:
    """A (6, 6) and b (6,) of a small turn about the centre and a shift that bring the surfels together: A x = -b.

    Of surfels under a pose T_target_source, with partners within the gate [m] that lie no farther than `slide` [m]
    along the surface; `least` [m^2] is added to every variance, and a residual of so many standard deviations counts a
    quarter.
    """
    A, b = np.zeros((_CHUNKS, 6, 6)), np.zeros((_CHUNKS, 6))
    over_slices(
        _accumulate_chunks, _CHUNKS, source.points, source.normals, source.variances + least, target.grid.points,
        target.normals, target.variances + least, target.grid.cells, target.grid.low, target.grid.cell, T, center, gate,
        slide, deviations**2, A, b,
    )  # fmt: skip
    return A.sum(axis=0), b.sum(axis=0)


@kernel
def _accumulate_chunks(
    start: int,
    stop: int,
    points: np.ndarray,
    normals: np.ndarray,
    variances: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    partner_variances: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    T: np.ndarray,
    center: np.ndarray,
    gate: float,
    slide: float,
    deviations: float,
    A: np.ndarray,
    b: np.ndarray,
) -> None:
    """Fill the normal equations of each chunk, A (chunks, 6, 6) and b (chunks, 6)."""
    n, chunks = len(points), len(A)
    for c in range(start, stop):
        accumulate(
            points, normals, variances, partners, partner_normals, partner_variances, cells, low, cell, T, center, gate,
            slide, deviations, c * n // chunks, (c + 1) * n // chunks, A[c], b[c],
        )  # fmt: skip


@kernel
def accumulate(
    points: np.ndarray,
    normals: np.ndarray,
    variances: np.ndarray,
    partners: np.ndarray,
    partner_normals: np.ndarray,
    partner_variances: np.ndarray,
    cells: Cells,
    low: np.ndarray,
    cell: float,
    T: np.ndarray,
    center: np.ndarray,
    gate: float,
    slide: float,
    deviations: float,
    start: int,
    stop: int,
    A: np.ndarray,
    b: np.ndarray,
) -> None:
    """Add to A (6, 6) and b (6,) what the points from start to stop say of a turn about the centre and a shift.

    Points, normals (N, 3) and variances (N,) of the source; the same of the partners, in their grid's order. A point
    counts by the inverse of both variances, and robustly: a quarter where the squared residual is `deviations` times
    the variance.
    """
    rows = np.empty((9, 2), np.int64)
    p, normal, a = np.empty(3), np.empty(3), np.empty(6)
    for i in range(start, stop):
        for k in range(3):
            p[k] = T[k, 0] * points[i, 0] + T[k, 1] * points[i, 1] + T[k, 2] * points[i, 2] + T[k, 3]
            normal[k] = T[k, 0] * normals[i, 0] + T[k, 1] * normals[i, 1] + T[k, 2] * normals[i, 2]
        nearest = nearest_partner(partners, partner_normals, cells, low, cell, p, normal, gate, rows)
        if nearest < 0:
            continue
        length, residual, squared = 0.0, 0.0, 0.0
        for k in range(3):
            normal[k] += partner_normals[nearest, k]
            length += normal[k] * normal[k]
        length = np.sqrt(length)
        for k in range(3):
            normal[k] /= length
            offset = p[k] - partners[nearest, k]
            residual += offset * normal[k]
            squared += offset * offset
        if squared - residual * residual > slide * slide:
            continue
        variance = variances[i] + partner_variances[nearest]
        weight = 1.0 / (1.0 + residual * residual / (deviations * variance))
        weight = weight * weight / variance
        x, y, z = p[0] - center[0], p[1] - center[1], p[2] - center[2]
        a[0], a[1], a[2] = y * normal[2] - z * normal[1], z * normal[0] - x * normal[2], x * normal[1] - y * normal[0]
        a[3], a[4], a[5] = normal[0], normal[1], normal[2]
        for k in range(6):
            b[k] += weight * a[k] * residual
            for m in range(6):
                A[k, m] += weight * a[k] * a[m]
