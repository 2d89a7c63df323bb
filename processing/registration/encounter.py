"""What the surfels of one view meet in another under a pose: a surface, what was looked through, or nothing."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from orbitscan.processing.registration.correspondences import find_correspondences
from orbitscan.processing.registration.free_space import look_up
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

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
    w, target = other.scale.working, other.fine_target
    points, normals = poses.transform(T_other_view, surfels.points), poses.rotate(T_other_view, surfels.normals)
    found = find_correspondences(points, normals, target, settings.gate * w)
    met = found >= 0
    at = found[met]
    along = normals[met] + target.normals[at]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    residuals = np.einsum("ni,ni->n", points[met] - target.grid.points[at], along)
    variances = surfels.variances[met] + target.variances[at] + (settings.deviation * w) ** 2
    in_front, unseen = np.zeros(len(points), bool), np.zeros(len(points), bool)
    if other.range_image is not None and not met.all():
        far, facing = points[~met], normals[~met]
        before, nothing = look_up(other.range_image, far, settings.front * w + _NOISE * other.scale.noise)
        to_sensor = other.surface.sensor_origin - far
        cosine = np.einsum("ni,ni->n", facing, to_sensor) / np.maximum(np.linalg.norm(to_sensor, axis=1), 1e-12)
        in_front[~met] = before & (np.abs(cosine) > settings.grazing_cosine)
        unseen[~met] = nothing & (cosine > settings.unseen_cosine)
    return Encounter(met, residuals, variances, in_front, unseen)
