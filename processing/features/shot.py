"""SHOT descriptors: histograms of normals in a repeatable local reference frame (thesis 4.1; Tombari 2010).

The conventions are PCL's, so that values can be compared: 8 azimuth x 2 radial x 2 elevation volumes of 11 cosine bins.
A neighbour adds, for each of the four quantities, 1 - d to its own bin and d to one adjacent bin; the cosine's adjacent
bin wraps modulo 10 as PCL's does.
"""

from dataclasses import dataclass

import numpy as np

from orbitscan.processing.kernels.eigen import symmetric_eigen
from orbitscan.processing.kernels.grid import Grid, build, rows_around
from orbitscan.recorder.kernels import kernel, over_slices

LENGTH = 352
_COSINE_STEPS = 10
_BINS = _COSINE_STEPS + 1
_MIN_FRAME_NEIGHBOURS = 5


@dataclass(frozen=True)
class ShotSettings:
    """Multiples of the working resolution w; not in the thesis."""

    radius: float = 15.0


def describe(
    points: np.ndarray, normals: np.ndarray, keypoints: np.ndarray, radius: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the descriptors (K, 352), float32 of unit length, and frames (K, 3, 3), rows x y z, of keypoints (K, 3).

    The neighbours are those of the points (N, 3), with normals (N, 3), within the radius [m]. A keypoint with fewer
    than five has no frame: its row is NaN. A neighbour without a normal counts for the frame only.
    """
    grid = build(points, radius)
    sorted_normals = np.ascontiguousarray(normals[grid.order], dtype=np.float64)
    keypoints = np.ascontiguousarray(keypoints, dtype=np.float64)
    descriptors = np.empty((len(keypoints), LENGTH), np.float32)
    frames = np.empty((len(keypoints), 3, 3))
    over_slices(_describe, len(keypoints), grid, sorted_normals, keypoints, frames, descriptors)
    return descriptors, frames


@kernel
def _describe(
    start: int,
    stop: int,
    grid: Grid,
    normals: np.ndarray,
    keypoints: np.ndarray,
    frames: np.ndarray,
    descriptors: np.ndarray,
) -> None:
    """Fill frames (K, 3, 3) and descriptors (K, 352) of the keypoints [start, stop); the grid's cell is the radius."""
    points, radius = grid.points, grid.cell
    rows = np.empty((9, 2), np.int64)
    histogram = np.empty(LENGTH)
    for i in range(start, stop):
        rows_around(grid, keypoints[i], rows)
        most = 0
        for r in range(9):
            most += rows[r, 1] - rows[r, 0]
        indices = np.empty(most, np.int64)
        offsets = np.empty((most, 4))
        count = _fill_neighbours(points, rows, keypoints[i], radius, indices, offsets)
        if count < _MIN_FRAME_NEIGHBOURS:
            frames[i] = np.nan
            descriptors[i] = np.nan
            continue
        _fill_frame(offsets, count, radius, frames[i])
        _fill_histogram(normals, indices, offsets, count, radius, frames[i], histogram)
        squared = 0.0
        for k in range(LENGTH):
            squared += histogram[k] * histogram[k]
        norm = np.sqrt(squared)
        for k in range(LENGTH):
            descriptors[i, k] = histogram[k] / norm if norm > 0.0 else 0.0


@kernel
def _fill_neighbours(
    points: np.ndarray, rows: np.ndarray, p: np.ndarray, radius: float, indices: np.ndarray, offsets: np.ndarray
) -> int:
    """Count the points of the rows that lie in the ball, the keypoint p itself left out.

    Fill indices (n,) and offsets (n, 4): from the keypoint, with the distance.
    """
    px, py, pz = p[0], p[1], p[2]
    count = 0
    for r in range(9):
        for j in range(rows[r, 0], rows[r, 1]):
            x, y, z = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
            squared = x * x + y * y + z * z
            if 0.0 < squared < radius * radius:
                indices[count] = j
                offsets[count, 0] = x
                offsets[count, 1] = y
                offsets[count, 2] = z
                offsets[count, 3] = np.sqrt(squared)
                count += 1
    return count


@kernel
def _fill_frame(offsets: np.ndarray, count: int, radius: float, frame: np.ndarray) -> None:
    """Fill frame (rows x, y, z) from the distance-weighted covariance about the keypoint."""
    cxx = cxy = cxz = cyy = cyz = czz = total = 0.0
    for i in range(count):
        x, y, z = offsets[i, 0], offsets[i, 1], offsets[i, 2]
        weight = radius - offsets[i, 3]
        total += weight
        cxx += weight * x * x
        cxy += weight * x * y
        cxz += weight * x * z
        cyy += weight * y * y
        cyz += weight * y * z
        czz += weight * z * z
    C, vectors = np.empty((3, 3)), np.empty((3, 3))
    C[0, 0], C[0, 1], C[0, 2] = cxx / total, cxy / total, cxz / total
    C[1, 0], C[1, 1], C[1, 2] = cxy / total, cyy / total, cyz / total
    C[2, 0], C[2, 1], C[2, 2] = cxz / total, cyz / total, czz / total
    symmetric_eigen(C, vectors)
    for j in range(0, 3, 2):  # x, then z
        back = _majority_points_back(offsets, count, vectors[0, 2 - j], vectors[1, 2 - j], vectors[2, 2 - j])
        for k in range(3):
            frame[j, k] = -vectors[k, 2 - j] if back else vectors[k, 2 - j]
    frame[1, 0] = frame[2, 1] * frame[0, 2] - frame[2, 2] * frame[0, 1]
    frame[1, 1] = frame[2, 2] * frame[0, 0] - frame[2, 0] * frame[0, 2]
    frame[1, 2] = frame[2, 0] * frame[0, 1] - frame[2, 1] * frame[0, 0]


@kernel
def _majority_points_back(offsets: np.ndarray, count: int, ax: float, ay: float, az: float) -> bool:
    """Whether most neighbours lie against the axis; on a tie, most of the five about the median distance."""
    ahead = 0
    for i in range(count):
        if offsets[i, 0] * ax + offsets[i, 1] * ay + offsets[i, 2] * az >= 0.0:
            ahead += 1
    if 2 * ahead != count:
        return 2 * ahead < count
    ahead = 0
    for i in range(count):
        rank = 0
        for j in range(count):
            if offsets[j, 3] < offsets[i, 3]:
                rank += 1
        if abs(rank - count // 2) <= 2 and offsets[i, 0] * ax + offsets[i, 1] * ay + offsets[i, 2] * az > 0.0:
            ahead += 1
    return ahead < 3


@kernel
def _fill_histogram(
    normals: np.ndarray,
    indices: np.ndarray,
    offsets: np.ndarray,
    count: int,
    radius: float,
    frame: np.ndarray,
    histogram: np.ndarray,
) -> None:
    """Fill the histogram (352,) with every neighbour."""
    for k in range(LENGTH):
        histogram[k] = 0.0
    half = radius / 2
    for j in range(count):
        nx, ny, nz = normals[indices[j], 0], normals[indices[j], 1], normals[indices[j], 2]
        if np.isnan(nx):
            continue
        dx, dy, dz, distance = offsets[j, 0], offsets[j, 1], offsets[j, 2], offsets[j, 3]
        x = dx * frame[0, 0] + dy * frame[0, 1] + dz * frame[0, 2]
        y = dx * frame[1, 0] + dy * frame[1, 1] + dz * frame[1, 2]
        z = dx * frame[2, 0] + dy * frame[2, 1] + dz * frame[2, 2]
        cosine = nx * frame[2, 0] + ny * frame[2, 1] + nz * frame[2, 2]

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
