"""SHOT descriptors: histograms of normals in a repeatable local reference frame (thesis 4.1; Tombari 2010).

The conventions are PCL's, so that values can be compared: 8 azimuth x 2 radial x 2 elevation volumes of 11 cosine bins.
A neighbour adds, for each of the four quantities, 1 - d to its own bin and d to one adjacent bin; the cosine's adjacent
bin wraps modulo 10 as PCL's does.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from processing.features.eigen import symmetric_eigen
from processing.features.grid import build, rows_around

LENGTH = 352
_COSINE_STEPS = 10
_BINS = _COSINE_STEPS + 1
_MIN_FRAME_NEIGHBOURS = 5


@dataclass(frozen=True)
class ShotSettings:
    """Multiples of the working resolution w; not in the thesis."""

    radius: float = 20.0


def describe(
    points: np.ndarray, normals: np.ndarray, keypoints: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """(descriptors (K, 352) float32 of unit length, frames (K, 3, 3) with rows x, y, z) of the keypoints (K, 3).

    The neighbours are those of the points (N, 3), with normals (N, 3), within the radius [m]. A keypoint with fewer
    than five has no frame: its row is NaN. A neighbour without a normal counts for the frame only.
    """
    grid = build(points, radius)
    sorted_normals = np.ascontiguousarray(normals[grid.order], dtype=np.float64)
    keypoints = np.ascontiguousarray(keypoints, dtype=np.float64)
    return _describe(grid.points, grid.keys, grid.low, grid.cell, sorted_normals, keypoints, float(radius))


@njit(parallel=True, cache=True)
def _describe(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    normals: np.ndarray,
    keypoints: np.ndarray,
    radius: float,
) -> tuple[np.ndarray, np.ndarray]:
    descriptors = np.empty((len(keypoints), LENGTH), np.float32)
    frames = np.empty((len(keypoints), 3, 3))
    for i in prange(len(keypoints)):
        _describe_one(points, keys, low, cell, normals, keypoints[i], radius, frames[i], descriptors[i])
    return descriptors, frames


@njit(cache=True)
def _describe_one(
    points: np.ndarray,
    keys: np.ndarray,
    low: np.ndarray,
    cell: float,
    normals: np.ndarray,
    keypoint: np.ndarray,
    radius: float,
    frame: np.ndarray,
    descriptor: np.ndarray,
) -> None:
    """Fill the frame (3, 3) and the descriptor (352,) of a keypoint."""
    indices, offsets = _neighbours(points, keys, low, cell, keypoint, radius)
    if len(indices) < _MIN_FRAME_NEIGHBOURS:
        frame[:] = np.nan
        descriptor[:] = np.nan
        return
    _fill_frame(offsets, radius, frame)
    histogram = np.zeros(LENGTH)
    _fill_histogram(normals, indices, offsets, radius, frame, histogram)
    norm = np.sqrt((histogram * histogram).sum())
    for k in range(LENGTH):
        descriptor[k] = histogram[k] / norm if norm > 0.0 else 0.0


@njit(cache=True)
def _neighbours(
    points: np.ndarray, keys: np.ndarray, low: np.ndarray, cell: float, p: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """(indices (n,), offsets from the keypoint with distances (n, 4)) of the points in the ball, itself left out."""
    rows = np.empty((9, 2), np.int64)
    rows_around(keys, low, cell, p, rows)
    most = (rows[:, 1] - rows[:, 0]).sum()
    indices = np.empty(most, np.int64)
    offsets = np.empty((most, 4))
    count = 0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - p[0], points[j, 1] - p[1], points[j, 2] - p[2]
            squared = x * x + y * y + z * z
            if 0.0 < squared < radius * radius:
                indices[count] = j
                offsets[count, 0] = x
                offsets[count, 1] = y
                offsets[count, 2] = z
                offsets[count, 3] = np.sqrt(squared)
                count += 1
    return indices[:count], offsets[:count]


@njit(cache=True)
def _fill_frame(offsets: np.ndarray, radius: float, frame: np.ndarray) -> None:
    """Fill frame (rows x, y, z) from the distance-weighted covariance about the keypoint."""
    cxx = cxy = cxz = cyy = cyz = czz = total = 0.0
    for x, y, z, distance in offsets:
        weight = radius - distance
        total += weight
        cxx += weight * x * x
        cxy += weight * x * y
        cxz += weight * x * z
        cyy += weight * y * y
        cyz += weight * y * z
        czz += weight * z * z
    C = np.array([[cxx, cxy, cxz], [cxy, cyy, cyz], [cxz, cyz, czz]]) / total
    vectors = np.empty((3, 3))
    symmetric_eigen(C, vectors)
    for k in range(3):
        frame[0, k] = vectors[k, 2]
        frame[2, k] = vectors[k, 0]
    for axis in (0, 2):
        if _majority_points_back(offsets, frame[axis]):
            for k in range(3):
                frame[axis, k] = -frame[axis, k]
    frame[1, 0] = frame[2, 1] * frame[0, 2] - frame[2, 2] * frame[0, 1]
    frame[1, 1] = frame[2, 2] * frame[0, 0] - frame[2, 0] * frame[0, 2]
    frame[1, 2] = frame[2, 0] * frame[0, 1] - frame[2, 1] * frame[0, 0]


@njit(cache=True)
def _majority_points_back(offsets: np.ndarray, axis: np.ndarray) -> bool:
    """Whether most neighbours lie against the axis; on a tie, most of the five about the median distance."""
    count = len(offsets)
    ahead = 0
    for x, y, z, _ in offsets:
        ahead += x * axis[0] + y * axis[1] + z * axis[2] >= 0.0
    if 2 * ahead != count:
        return 2 * ahead < count
    ahead = 0
    for x, y, z, distance in offsets:
        rank = (offsets[:, 3] < distance).sum()
        if abs(rank - count // 2) <= 2:
            ahead += x * axis[0] + y * axis[1] + z * axis[2] > 0.0
    return ahead < 3


@njit(cache=True)
def _fill_histogram(
    normals: np.ndarray,
    indices: np.ndarray,
    offsets: np.ndarray,
    radius: float,
    frame: np.ndarray,
    histogram: np.ndarray,
) -> None:
    """Add every neighbour to the histogram (352,)."""
    half = radius / 2
    for j in range(len(indices)):
        normal = normals[indices[j]]
        if np.isnan(normal[0]):
            continue
        dx, dy, dz, distance = offsets[j]
        x = dx * frame[0, 0] + dy * frame[0, 1] + dz * frame[0, 2]
        y = dx * frame[1, 0] + dy * frame[1, 1] + dz * frame[1, 2]
        z = dx * frame[2, 0] + dy * frame[2, 1] + dz * frame[2, 2]
        cosine = normal[0] * frame[2, 0] + normal[1] * frame[2, 1] + normal[2] * frame[2, 2]

        position = (1.0 + min(1.0, max(-1.0, cosine))) * _COSINE_STEPS / 2
        step = int(np.floor(position + 0.5))
        azimuth = np.arctan2(y, x)
        sector = min(7, int((azimuth + np.pi) / (np.pi / 4)))
        outer = 1 if distance > half else 0
        upper = 1 if z > 0.0 else 0
        volume = sector * 4 + outer * 2 + upper

        off_step = position - step
        beside = (step + 1) % _COSINE_STEPS if off_step > 0.0 else (step - 1 + _COSINE_STEPS) % _COSINE_STEPS
        histogram[volume * _BINS + beside] += abs(off_step)

        off_shell = (distance - (0.75 if outer else 0.25) * radius) / half
        if (off_shell > 0.0) != (outer == 1):  # towards the other shell
            histogram[(volume + (2 if outer == 0 else -2)) * _BINS + step] += abs(off_shell)

        inclination = np.arccos(min(1.0, max(-1.0, z / distance)))
        off_cone = (inclination - (0.25 if upper else 0.75) * np.pi) / (np.pi / 2)
        if (off_cone > 0.0) == (upper == 1):  # towards the other half
            histogram[(volume + (-1 if upper else 1)) * _BINS + step] += abs(off_cone)

        off_sector = (azimuth - (-7 * np.pi / 8 + sector * np.pi / 4)) / (np.pi / 4)
        off_sector = min(0.5, max(-0.5, off_sector))
        beside = (volume + (4 if off_sector > 0.0 else 28)) % 32
        histogram[beside * _BINS + step] += abs(off_sector)

        histogram[volume * _BINS + step] += 4.0 - abs(off_step) - abs(off_shell) - abs(off_cone) - abs(off_sector)
