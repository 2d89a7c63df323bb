"""The least-squares problem of bringing two surfaces together, linearised: distances along the mean of both normals."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.correspondences import Target, nearest_surfel
from orbitscan.recorder import poses
from orbitscan.recorder.kernels import kernel, over_slices

_CHUNKS = 16  # sums are made in so many parts, whatever the number of threads: the same bits on every machine


class Problem(NamedTuple):
    """The surfels to bring together, and how much a residual between two of them counts."""

    points: np.ndarray  # (N, 3) of the source
    normals: np.ndarray  # (N, 3)
    variances: np.ndarray  # (N,) [m^2]
    target: Target
    gate: float  # [m] to the corresponding surfel, at most
    slide: float  # [m] the same along the surface
    cutoff_squared: float  # a residual counts a quarter whose square is so many times the variance


def normal_equations(problem: Problem, T: np.ndarray, center: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return A (6, 6) and b (6,) of a turn [rad] about the centre (3,) and a shift [m] that improve T_target_source.

    A x = -b is their solution; both are zero where no surfels correspond.
    """
    A, b = np.zeros((_CHUNKS, 6, 6)), np.zeros((_CHUNKS, 6))
    over_slices(_accumulate_chunks, _CHUNKS, problem, T, center, A, b)
    return A.sum(axis=0), b.sum(axis=0)


def motion(x: np.ndarray, center: np.ndarray) -> np.ndarray:
    """The motion (4, 4) of a turn [rad] about a centre (3,) and then a shift [m], x (6,)."""
    R = Rotation.from_rotvec(x[:3]).as_matrix()
    return poses.make(R, center + x[3:] - R @ center)


@kernel
def _accumulate_chunks(
    start: int, stop: int, problem: Problem, T: np.ndarray, center: np.ndarray, A: np.ndarray, b: np.ndarray
) -> None:
    """Fill the normal equations of the chunks [start, stop), A (chunks, 6, 6) and b (chunks, 6)."""
    n, chunks = len(problem.points), len(A)
    for c in range(start, stop):
        accumulate(problem, T, center, (c * n // chunks, (c + 1) * n // chunks), A[c], b[c])


@kernel
def accumulate(
    problem: Problem, T: np.ndarray, center: np.ndarray, part: tuple[int, int], A: np.ndarray, b: np.ndarray
) -> None:
    """Add to A (6, 6) and b (6,) what the source's surfels from part[0] to part[1] say.

    A surfel counts by the inverse of both variances, and robustly (see `Problem.cutoff_squared`).
    """
    points, normals, variances, target = problem.points, problem.normals, problem.variances, problem.target
    others, other_normals, other_variances = target.grid.points, target.normals, target.variances
    rows = np.empty((9, 2), np.int64)
    p, normal, a = np.empty(3), np.empty(3), np.empty(6)
    for i in range(part[0], part[1]):
        for k in range(3):
            p[k] = T[k, 0] * points[i, 0] + T[k, 1] * points[i, 1] + T[k, 2] * points[i, 2] + T[k, 3]
            normal[k] = T[k, 0] * normals[i, 0] + T[k, 1] * normals[i, 1] + T[k, 2] * normals[i, 2]
        nearest = nearest_surfel(target, p, normal, problem.gate, rows)
        if nearest < 0:
            continue
        length, residual, squared = 0.0, 0.0, 0.0
        for k in range(3):
            normal[k] += other_normals[nearest, k]
            length += normal[k] * normal[k]
        length = np.sqrt(length)
        for k in range(3):
            normal[k] /= length
            offset = p[k] - others[nearest, k]
            residual += offset * normal[k]
            squared += offset * offset
        if squared - residual * residual > problem.slide * problem.slide:
            continue
        variance = variances[i] + other_variances[nearest]
        weight = 1.0 / (1.0 + residual * residual / (problem.cutoff_squared * variance))
        weight = weight * weight / variance
        x, y, z = p[0] - center[0], p[1] - center[1], p[2] - center[2]
        a[0], a[1], a[2] = y * normal[2] - z * normal[1], z * normal[0] - x * normal[2], x * normal[1] - y * normal[0]
        a[3], a[4], a[5] = normal[0], normal[1], normal[2]
        for k in range(6):
            b[k] += weight * a[k] * residual
            for m in range(6):
                A[k, m] += weight * a[k] * a[m]
