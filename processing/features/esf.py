"""Ensemble of shape functions (ESF): distances, angles, areas of random triangles of a cloud (Wohlkinger, ROBIO 2011).

Whether a triangle's sides run inside the shape, outside or both is read from a grid of 64^3 voxels. The conventions are
PCL's (1.13), so that distributions can be compared. Not part of the registration: for comparisons of descriptors.
"""

import numpy as np
from scipy.ndimage import maximum_filter

from orbitscan.recorder.kernels import kernel, over_slices

SAMPLES = 20_000  # triangles
BINS = 64  # of each histogram
LENGTH = 10 * BINS
_SIDE = 64  # voxels along an axis
_MIN_POINTS = 3
_MOST_DRAWS = 50  # of SAMPLES triples each; a cloud on a line has no triangles
_LEAST_AREA = 0.001**0.5  # in voxels, of a triangle
_INSIDE, _OUTSIDE, _MIXED = range(3)
_FEW_OF_SIDE, _FEW_OF_TRIANGLE = 7, 21  # occupied voxels of what runs outside
_GAPS_OF_SIDE, _GAPS_OF_TRIANGLE = 1, 3  # empty voxels of what runs inside, at most
# Of the angles (inside, outside, mixed), the areas, the distances, and the occupied shares of mixed sides.
_WEIGHTS = (0.5, 0.5, 0.5, 0.5, 0.5, 1.0, 0.5, 2.0, 2.0, 1.0)


def describe(points: np.ndarray, rng: np.random.Generator | int) -> np.ndarray:
    """The descriptor (640,) float32, of sum 1, of a whole cloud (N, 3); NaN where no three points make a triangle.

    Ten histograms of 64 bins: the triangles' angles, square roots of areas, and sides, each inside, outside and mixed,
    then the occupied share of mixed sides. Lengths count relative to the largest: the scale does not show. The
    triangles are drawn by the generator or its seed.
    """
    missing = np.full(LENGTH, np.nan, np.float32)
    if len(points) < _MIN_POINTS:
        return missing
    centred = np.asarray(points, dtype=np.float64) - np.mean(points, axis=0, dtype=np.float64)
    extent = np.linalg.norm(centred, axis=1).max()
    if extent == 0.0:
        return missing
    scaled = centred * (_SIDE / 2 / extent)
    triangles = _draw(scaled, np.random.default_rng(rng))
    return missing if triangles is None else _histograms(scaled, triangles)


def _draw(points: np.ndarray, rng: np.random.Generator) -> np.ndarray | None:
    """Triples (SAMPLES, 3) of the points' indices that make triangles; None where hardly any do."""
    kept, count = [], 0
    for _ in range(_MOST_DRAWS):
        triples = rng.integers(len(points), size=(SAMPLES, 3))
        triples = triples[_areas(points[triples]) > _LEAST_AREA]
        kept.append(triples)
        count += len(triples)
        if count >= SAMPLES:
            return np.concatenate(kept)[:SAMPLES]
    return None


def _areas(corners: np.ndarray) -> np.ndarray:
    """The areas (M,) of triangles (M, 3, 3)."""
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2


def _histograms(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """The descriptor (640,) of triangles (M, 3) of the points (N, 3), which are in voxels about the grid's centre."""
    cells = _cells(points)
    occupied = np.zeros((_SIDE, _SIDE, _SIDE), np.bool_)
    occupied[cells[:, 0], cells[:, 1], cells[:, 2]] = True
    occupied = maximum_filter(occupied, size=3, mode="constant")

    corners = points[triangles]  # (M, 3, 3)
    sides = corners[:, [2, 0, 1]] - corners[:, [1, 2, 0]]  # side k lies opposite to corner k
    lengths = np.linalg.norm(sides, axis=2)
    directions = sides / lengths[:, :, None]
    cosines = np.abs(np.einsum("mki,mki->mk", directions[:, [1, 2, 0]], directions[:, [2, 0, 1]]))
    angles = np.arccos(np.minimum(cosines, 1.0)) / (np.pi / 2)
    areas = np.sqrt(_areas(corners))

    # From the first named corner to the second: the direction decides which voxels a side passes.
    ends = cells[triangles[:, [[1, 2], [0, 2], [0, 1]]]].reshape(-1, 2, 3)  # (3 M, 2, 3)
    passed, full = np.empty((len(triangles), 3), np.int64), np.empty((len(triangles), 3), np.int64)
    over_slices(_trace, len(ends), occupied, ends, passed.reshape(-1), full.reshape(-1))
    side = _kind(passed, full, _GAPS_OF_SIDE, _FEW_OF_SIDE, inside_first=True)
    triangle = _kind(passed.sum(axis=1), full.sum(axis=1), _GAPS_OF_TRIANGLE, _FEW_OF_TRIANGLE, inside_first=False)

    mixed = side == _MIXED
    blocks = [
        _by_kind(angles, np.repeat(triangle[:, None], 3, axis=1), passed / (_SIDE / 2)),
        _by_kind(areas / areas.max(), triangle),
        _by_kind(lengths / lengths.max(), side),
        _histogram(full[mixed] / passed[mixed]),
    ]
    descriptor = np.concatenate(blocks) * np.repeat(_WEIGHTS, BINS)
    return (descriptor / descriptor.sum()).astype(np.float32)


def _cells(points: np.ndarray) -> np.ndarray:
    """The voxels (N, 3) of points (N, 3) about the grid's centre; a border belongs to the voxel nearer to it."""
    cells = np.where(points < 0, np.floor(points), np.ceil(points) - 1) + _SIDE // 2
    return np.clip(cells, 0, _SIDE - 1).astype(np.int64)


def _kind(passed: np.ndarray, full: np.ndarray, gaps: int, few: int, inside_first: bool) -> np.ndarray:
    """Inside, outside or mixed, by the voxels passed and those of them occupied."""
    inside, outside = passed - full <= gaps, full <= few
    if inside_first:
        return np.where(inside, _INSIDE, np.where(outside, _OUTSIDE, _MIXED))
    return np.where(outside, _OUTSIDE, np.where(inside, _INSIDE, _MIXED))


def _by_kind(values: np.ndarray, kind: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """Three histograms (192,) of values from 0 to 1: inside, outside, mixed."""
    weights = np.ones(values.shape) if weights is None else weights
    return np.concatenate([_histogram(values[kind == k], weights[kind == k]) for k in (_INSIDE, _OUTSIDE, _MIXED)])


def _histogram(values: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
    """The histogram (64,) of values from 0 to 1, each rounded to the nearest step."""
    return np.bincount(np.floor(values * (BINS - 1) + 0.5).astype(np.int64), weights, minlength=BINS)


@kernel
def _trace(start: int, stop: int, occupied: np.ndarray, ends: np.ndarray, passed: np.ndarray, full: np.ndarray) -> None:
    """Fill, for the lines [start, stop) of ends (L, 2, 3), how many voxels are passed and how many are occupied.

    Bresenham's line, the last voxel left out.
    """
    at, step, far, error = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(start, stop):
        longest = 0
        for k in range(3):
            at[k] = ends[i, 0, k]
            step[k] = 1 if ends[i, 1, k] > at[k] else -1
            far[k] = abs(ends[i, 1, k] - at[k])
            longest = max(longest, far[k])
        for k in range(3):
            error[k] = 2 * far[k] - longest
        count = 0
        for _ in range(max(1, longest)):
            if occupied[at[0], at[1], at[2]]:
                count += 1
            for k in range(3):
                if error[k] > 0:
                    at[k] += step[k]
                    error[k] -= 2 * longest
                error[k] += 2 * far[k]
        passed[i] = max(1, longest)
        full[i] = count
