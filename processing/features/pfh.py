"""PFH descriptors: how the normals of all pairs of neighbours turn about each other (Rusu et al., IROS 2008).

The conventions and the float32 arithmetic are PCL's (1.13), so that values can be compared: three angles of five steps
each; the distance, f4, is not used. Not part of the registration: for comparisons of descriptors.
"""

import numpy as np

from orbitscan.processing.kernels.grid import Grid, build, rows_around
from orbitscan.recorder.kernels import kernel, over_slices

STEPS = 5  # of each angle
LENGTH = STEPS**3
_TOTAL = np.float32(100.0)
_PER_TURN = np.float32(1.0) / (np.float32(2.0) * np.float32(np.pi))
_NO_DIFFERENCE = np.float32(1e-5)  # of two cosines whose angles may be one float32 number


def describe(points: np.ndarray, normals: np.ndarray, keypoints: np.ndarray, radius: float) -> np.ndarray:
    """Descriptors (K, 125) float32, each of sum 100, of the keypoints (K, 3).

    Of the points (N, 3), with unit normals (N, 3), those with a normal within the radius [m] count, the keypoint too
    where it is one of them; fewer than two: the row is NaN. Bin a + 5 p + 25 t holds the pairs whose alpha, phi and
    theta fall in steps a (alpha: from -pi to pi), p and t (their cosines: from -1 to 1). The time grows with the square
    of the number of neighbours.
    """
    known = np.isfinite(normals).all(axis=1)
    grid = build(points[known], radius)
    sorted_normals = np.ascontiguousarray(normals[known][grid.order], dtype=np.float32)
    keypoints = np.ascontiguousarray(keypoints, dtype=np.float64)
    descriptors = np.empty((len(keypoints), LENGTH), np.float32)
    over_slices(_describe, len(keypoints), grid, sorted_normals, keypoints, descriptors)
    return descriptors


@kernel
def _describe(
    start: int, stop: int, grid: Grid, normals: np.ndarray, keypoints: np.ndarray, descriptors: np.ndarray
) -> None:
    """Fill descriptors (K, 125) of the keypoints [start, stop); the grid's cell is the radius."""
    points, radius = grid.points, grid.cell
    rows = np.empty((9, 2), np.int64)
    for i in range(start, stop):
        px, py, pz = keypoints[i, 0], keypoints[i, 1], keypoints[i, 2]
        rows_around(grid, keypoints[i], rows)
        most = 0
        for r in range(9):
            most += rows[r, 1] - rows[r, 0]
        positions = np.empty((most, 3), np.float32)
        directions = np.empty((most, 3), np.float32)
        count = 0
        for r in range(9):
            for j in range(rows[r, 0], rows[r, 1]):
                x, y, z = points[j, 0] - px, points[j, 1] - py, points[j, 2] - pz
                if x * x + y * y + z * z < radius * radius:
                    for k in range(3):
                        positions[count, k] = points[j, k]
                        directions[count, k] = normals[j, k]
                    count += 1
        _fill_histogram(positions, directions, count, descriptors[i])


@kernel
def _fill_histogram(points: np.ndarray, normals: np.ndarray, count: int, histogram: np.ndarray) -> None:
    """Fill the histogram (125,) with every pair of the first count points (n, 3), with normals (n, 3)."""
    for k in range(LENGTH):
        histogram[k] = 0.0 if count > 1 else np.nan
    share = np.float32(_TOTAL / np.float32(count * (count - 1) // 2))
    for i in range(count):
        for j in range(i):
            alpha, phi, theta = _pair(points, normals, i, j)
            a = _step((alpha + np.pi) * _PER_TURN)
            p = _step((phi + 1.0) * 0.5)
            t = _step((theta + 1.0) * 0.5)
            histogram[a + STEPS * (p + STEPS * t)] += share


@kernel
def _step(position: float) -> int:
    """The step of a position from 0 to 1."""
    return min(STEPS - 1, max(0, int(np.floor(STEPS * position))))


@kernel
def _pair(points: np.ndarray, normals: np.ndarray, i: int, j: int) -> tuple[np.float32, np.float32, np.float32]:
    """Return alpha, phi, theta of a pair: an angle and two cosines; zeros where the pair has no Darboux frame.

    The source is the point whose normal makes the smaller angle with the line; u is its normal n, v = d x u / |d x u|
    with d from source to target, w = u x v. With the target's normal m: alpha = atan2(w.m, u.m), phi = v.m and
    theta = u.d / |d|.
    """
    zero = np.float32(0.0)
    dx, dy, dz = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1], points[j, 2] - points[i, 2]
    length = np.sqrt(_dot(dx, dy, dz, dx, dy, dz))
    if length == zero:
        return zero, zero, zero
    ux, uy, uz = normals[i, 0], normals[i, 1], normals[i, 2]
    mx, my, mz = normals[j, 0], normals[j, 1], normals[j, 2]
    theta = _dot(ux, uy, uz, dx, dy, dz) / length
    other = _dot(mx, my, mz, dx, dy, dz) / length
    if _closer(abs(other), abs(theta)):
        ux, uy, uz, mx, my, mz = mx, my, mz, ux, uy, uz
        dx, dy, dz = -dx, -dy, -dz
        theta = -other
    vx, vy, vz = dy * uz - dz * uy, dz * ux - dx * uz, dx * uy - dy * ux
    norm = np.sqrt(_dot(vx, vy, vz, vx, vy, vz))
    if norm == zero:
        return zero, zero, zero
    vx, vy, vz = vx / norm, vy / norm, vz / norm
    wx, wy, wz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    alpha = np.arctan2(_dot(wx, wy, wz, mx, my, mz), _dot(ux, uy, uz, mx, my, mz))
    return alpha, _dot(vx, vy, vz, mx, my, mz), theta


@kernel
def _dot(ax: float, ay: float, az: float, bx: float, by: float, bz: float) -> float:
    """The inner product, summed in the order of PCL's four-lane registers."""
    return (ax * bx + az * bz) + ay * by


@kernel
def _closer(first: float, second: float) -> bool:
    """Whether the angle of the first cosine is smaller than that of the second, as float32 numbers."""
    if abs(first - second) > _NO_DIFFERENCE:
        return first > second
    return np.arccos(second) > np.arccos(first)
