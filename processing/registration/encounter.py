"""What the surfels of one view meet in another under a pose: a surface, what was looked through, or nothing."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitscan.processing.registration.correspondences import Target, nearest_surfel, over_points
from orbitscan.processing.registration.free_space import IN_FRONT, UNSEEN, RangeImage, look
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder.kernels import kernel

_MET = 3  # what a surfel may be, besides IN_FRONT and UNSEEN
_NO_IMAGE = RangeImage(np.eye(4), 1.0, np.zeros(2), np.full((1, 1), np.inf), np.ones((1, 1), bool))  # no sensor's
_NOISE = 4.0  # standard deviations of a point by which it may lie before a surface, besides the settings' share


@dataclass(frozen=True)
class EncounterSettings:
    """What counts as meeting a surface; lengths in multiples of the working resolution; not in the thesis."""

    gate: float = 2.0  # a surfel that is met is no farther
    deviation: float = 0.2  # of a residual, besides what both surfels' variances explain
    front: float = 1.5  # a point so far before a surface, and four times the noise, contradicts it ...
    grazing_cosine: float = 0.35  # ... unless the other sensor would see it edge-on, and may have missed it
    unseen_cosine: float = 0.45  # a point that faces a sensor so should have been seen by it


class Encounter(NamedTuple):
    """What each of N surfels meets."""

    met: np.ndarray  # (N,) bool: a surfel of the other view that faces the same way
    residuals: np.ndarray  # (M,) distances along both normals [m] of those M that meet one
    variances: np.ndarray  # (M,) that explain them [m^2]
    in_front: np.ndarray  # (N,) bool: lies where the other sensor looked through to a surface behind
    unseen: np.ndarray  # (N,) bool: faces the other sensor, which saw nothing there


def meet(T_other_view: np.ndarray, surfels: Surfels, other: PreparedView, settings: EncounterSettings) -> Encounter:
    """Find what a view's surfels meet in another view; nothing is in front or unseen where its sensor is unknown."""
    w, image, sensor = other.scale.working, other.range_image, other.surface.sensor_origin
    if image is None or sensor is None:
        image, sensor = _NO_IMAGE, np.full(3, np.nan)
    limits = _Limits(
        gate=settings.gate * w,
        least=(settings.deviation * w) ** 2,
        front=settings.front * w + _NOISE * other.scale.noise,
        grazing_cosine=settings.grazing_cosine,
        unseen_cosine=settings.unseen_cosine,
    )
    count = len(surfels)
    what, residuals, variances = np.empty(count, np.int64), np.empty(count), np.empty(count)
    fixed = T_other_view, surfels.points, surfels.normals, surfels.variances, other.fine_target, image, sensor, limits
    over_points(_meet_each, count, *fixed, what, residuals, variances)
    met = what == _MET
    return Encounter(met, residuals[met], variances[met], what == IN_FRONT, what == UNSEEN)


class _Limits(NamedTuple):
    gate: float  # [m]
    least: float  # [m^2]
    front: float  # [m]
    grazing_cosine: float
    unseen_cosine: float


@kernel
def _meet_each(
    start: int,
    stop: int,
    T: np.ndarray,
    all_points: np.ndarray,
    all_normals: np.ndarray,
    all_variances: np.ndarray,
    target: Target,
    image: RangeImage,
    sensor: np.ndarray,
    limits: _Limits,
    what: np.ndarray,
    residuals: np.ndarray,
    variances: np.ndarray,
) -> None:
    """Fill the rows [start, stop) of what surfels are, residuals and variances (N,); an unknown sensor (3,) is NaN."""
    rows, p, n = np.empty((9, 2), np.int64), np.empty(3), np.empty(3)
    others, other_normals = target.grid.points, target.normals
    for i in range(start, stop):
        for k in range(3):
            x, y, z = all_points[i, 0], all_points[i, 1], all_points[i, 2]
            p[k] = x * T[k, 0] + y * T[k, 1] + z * T[k, 2] + T[k, 3]
            x, y, z = all_normals[i, 0], all_normals[i, 1], all_normals[i, 2]
            n[k] = x * T[k, 0] + y * T[k, 1] + z * T[k, 2]
        at = nearest_surfel(target, p, n, limits.gate, rows)
        if at >= 0:
            length, residual = 0.0, 0.0
            for k in range(3):
                along = n[k] + other_normals[at, k]
                length += along * along
                residual += (p[k] - others[at, k]) * along
            what[i], residuals[i] = _MET, residual / np.sqrt(length)
            variances[i] = all_variances[i] + target.variances[at] + limits.least
            continue
        what[i] = 0
        if np.isnan(sensor[0]):
            continue
        cosine, far = 0.0, 0.0
        for k in range(3):
            cosine += n[k] * (sensor[k] - p[k])
            far += (sensor[k] - p[k]) ** 2
        cosine /= max(np.sqrt(far), 1e-12)
        seen = look(image, p, limits.front)
        if (seen == IN_FRONT and abs(cosine) > limits.grazing_cosine) or (
            seen == UNSEEN and cosine > limits.unseen_cosine
        ):
            what[i] = seen
