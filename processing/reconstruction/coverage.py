"""From where the placed views look at the object: their azimuths about the upright axis, and those that none covers."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.results.records import Coverage, Gap, Model, Turntable
from orbitscan.recorder import poses

_LEVEL = np.sin(np.radians(10.0))  # how far cameras taken to be level may roll, root mean square
_SPREAD = 0.2  # of their level axes, root mean square: that of an arc of 40 degrees


@dataclass(frozen=True)
class CoverageSettings:
    """When azimuths without a view are told; not in the thesis."""

    widest_deg: float = 45.0  # between neighbours; farther apart they share little of a surface
    min_views: int = 3
    pole_deg: float = 20.0  # a view from closer to the axis has no azimuth


def measure_coverage(
    T_0: Mapping[int, np.ndarray],
    sensor_origin: tuple[float, ...] | None,
    model: Model | None,
    turntable: Turntable | None,
    settings: CoverageSettings,
) -> Coverage | None:
    """The azimuths of views placed by T_0_i (in capture order) and those between them that no view covers.

    They are about the turntable's axis, else about what the cameras call up, through the middle of the model.
    `sensor_origin` is where the sensor stands in a view's frame [m]; None: it looks along z from far away. None where
    azimuths cannot be told: too few views have one, or there is neither a turntable nor a common up.
    """
    if model is None or not len(model.points):
        return None
    if turntable is None:
        up, center = find_up(T_0, settings.min_views), np.percentile(model.points, [1, 99], axis=0).mean(axis=0)
    else:
        up, center = turntable.axis, turntable.point
        if up @ _mean_up(T_0) < 0:
            up = -up
    if up is None:
        return None
    sensor = None if sensor_origin is None else np.array(sensor_origin, dtype=float)
    level: dict[int, np.ndarray] = {}
    for view, T in T_0.items():
        away = -T[:3, 2] if sensor is None else poses.transform(T, sensor[None])[0] - center
        flat = away - (away @ up) * up
        if np.linalg.norm(flat) > np.sin(np.radians(settings.pole_deg)) * np.linalg.norm(away):
            level[view] = flat / np.linalg.norm(flat)
    if len(level) < settings.min_views:
        return None
    forward = next(iter(level.values()))
    left = np.cross(up, forward)
    angles = {view: float(np.degrees(np.arctan2(d @ left, d @ forward))) for view, d in level.items()}
    azimuths = {view: round(angle, 9) % 360 for view, angle in angles.items()}  # rounded: a hair below 0 is not 360
    return Coverage(up, center, forward, azimuths, find_gaps(azimuths, settings.widest_deg))


def find_gaps(azimuths_deg: Mapping[int, float], widest_deg: float) -> tuple[Gap, ...]:
    """The arcs between neighbouring azimuths that are wider than `widest_deg`, the widest first."""
    ring = sorted(azimuths_deg, key=azimuths_deg.__getitem__)
    gaps = []
    for k, after in enumerate(ring):
        before, turns = (ring[k + 1], 0) if k + 1 < len(ring) else (ring[0], 360)
        gap = Gap(azimuths_deg[after], azimuths_deg[before] + turns, after, before)
        if gap.end_deg - gap.start_deg > widest_deg:
            gaps.append(gap)
    return tuple(sorted(gaps, key=lambda gap: (gap.start_deg - gap.end_deg, gap.start_deg)))


def find_up(T_0: Mapping[int, np.ndarray], min_views: int) -> np.ndarray | None:
    """The direction (3,) that level cameras call up: square to the x axes of all; None where they share none.

    It is the least singular vector of those axes, whatever the cameras' elevations.
    """
    if len(T_0) < min_views:
        return None
    across = np.array([T[:3, 0] for T in T_0.values()])
    spread, directions = np.linalg.svd(across, full_matrices=False)[1:]
    spread = spread / np.sqrt(len(across))
    if spread[2] > _LEVEL or spread[1] < max(_SPREAD, 2 * spread[2]):
        return None
    up = directions[2]
    return up if up @ _mean_up(T_0) >= 0 else -up


def _mean_up(T_0: Mapping[int, np.ndarray]) -> np.ndarray:
    """The mean of the cameras' ups, whose y points down."""
    return np.mean([-T[:3, 1] for T in T_0.values()], axis=0)
