"""Free space: what a view's sensor looked through to the surface it saw is empty."""

from typing import NamedTuple

import numpy as np
from scipy.ndimage import minimum_filter

from orbitscan.recorder import poses
from orbitscan.recorder.kernels import kernel

IN_FRONT, UNSEEN = 1, 2  # what a point may be
_MAX_PIXELS = 4_000_000  # of a range image; a stray point far off makes the pixels coarser, not the image larger
_NEAR = 3  # pixels across: a surface may be as near as the nearest of this neighbourhood
_HOLE = 5  # pixels across: nothing was seen where such a neighbourhood is empty
_WIDEST = 0.1  # cosine: directions farther from the one to the object are no part of an image
_MOST_OUTSIDE = 0.1  # share of the points that may lie in such directions: more, and the sensor stands amid them


class RangeImage(NamedTuple):
    """How far a view's sensor saw, in directions about the one to the object."""

    T_image_view: np.ndarray  # (4, 4): the sensor at the origin, z towards the object
    size: float  # of a pixel, tangent of its angle
    low: np.ndarray  # (2,) tangents at the image's corner
    near: np.ndarray  # (H, W) depth [m] of the nearest point seen there or in the pixels around; inf where none
    empty: np.ndarray  # (H, W) bool: nothing was seen there or around


def make_range_image(points: np.ndarray, sensor_origin: np.ndarray, pixel: float) -> RangeImage | None:
    """Make the range image of a view's points (N, 3) from its sensor (3,); a pixel's width at the object is in metres.

    None where the sensor stands amid the points: an image holds what lies before it.
    """
    T = _look_at(sensor_origin, points.mean(axis=0, dtype=np.float64))
    local = poses.transform(T, points)
    before = local[:, 2] > _WIDEST * np.linalg.norm(local, axis=1)
    if np.mean(~before) > _MOST_OUTSIDE:
        return None
    local = local[before]
    tangents = local[:, :2] / local[:, 2:]
    low, high = tangents.min(axis=0), tangents.max(axis=0)
    distance = float(local[:, 2].mean())
    size = max(pixel / distance, float(np.sqrt((high - low).prod() / _MAX_PIXELS)))
    low = low - _HOLE * size  # a margin, so that the borders' neighbourhoods lie inside
    columns, rows = ((tangents - low) / size).astype(np.int64).T
    width, height = (np.ceil((high - low) / size).astype(int) + _HOLE + 1).tolist()
    depth = np.full((height, width), np.inf)
    np.minimum.at(depth, (rows, columns), local[:, 2])
    near = minimum_filter(depth, _NEAR, mode="constant", cval=np.inf)
    return RangeImage(T, size, low, near, np.isinf(minimum_filter(depth, _HOLE, mode="constant", cval=np.inf)))


@kernel
def look(image: RangeImage, p: np.ndarray, tolerance: float) -> int:
    """Tell whether a point (3,) in the view's frame lies where nothing can be: IN_FRONT, UNSEEN, or 0 where it may.

    In front: nearer to the sensor than all it saw in that direction, by more than the tolerance [m]. Unseen: where the
    sensor saw nothing at all, be it the background or a surface it failed to measure.
    """
    T = image.T_image_view
    x = p[0] * T[0, 0] + p[1] * T[0, 1] + p[2] * T[0, 2] + T[0, 3]
    y = p[0] * T[1, 0] + p[1] * T[1, 1] + p[2] * T[1, 2] + T[1, 3]
    z = p[0] * T[2, 0] + p[1] * T[2, 1] + p[2] * T[2, 2] + T[2, 3]
    if z <= 0.0:
        return UNSEEN
    column, row = np.floor((x / z - image.low[0]) / image.size), np.floor((y / z - image.low[1]) / image.size)
    height, width = image.near.shape
    if column < 0 or row < 0 or column >= width or row >= height:
        return UNSEEN
    i, j = int(row), int(column)
    if z < image.near[i, j] - tolerance and np.isfinite(image.near[i, j]):
        return IN_FRONT
    return UNSEEN if image.empty[i, j] else 0


def _look_at(eye: np.ndarray, center: np.ndarray) -> np.ndarray:
    """Return T_image_view (4, 4) of a sensor at `eye` whose z axis goes through `center`, turned about z in any way."""
    distance = float(np.linalg.norm(center - eye))
    forward = (center - eye) / distance if distance > 0 else np.array([0.0, 0.0, 1.0])
    aside = np.eye(3)[int(np.abs(forward).argmin())]
    right = np.cross(aside, forward)
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(forward, right), forward])
    return poses.make(R, -R @ eye)
