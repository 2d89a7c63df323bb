"""From where the placed views look at the object: their azimuths about the upright axis, and those that none covers."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.results.records import Turntable
from orbitscan.recorder import poses

WIDEST_DEG = 45.0  # between neighbours; farther apart they share little of a surface
MIN_VIEWS = 3
POLE_DEG = 20.0  # a view from closer to the axis has no azimuth
_LEVEL = np.sin(np.radians(10.0))  # how far cameras taken to be level may roll, root mean square
_SPREAD = 0.2  # of their level axes, root mean square: that of an arc of 40 degrees


@dataclass(frozen=True)
class Gap:
    """An arc without a view, from one view to the next counterclockwise; `end_deg` may exceed 360."""

    start_deg: float
    end_deg: float
    after: int  # the recorded index of the view it begins at
    before: int


@dataclass(frozen=True, eq=False)
class Coverage:
    """The azimuths of views about an axis that points up, counterclockwise seen from above; the first view's is 0."""

    up: np.ndarray  # (3,) unit, in frame {0}
    center: np.ndarray  # (3,) metres, on the axis
    forward: np.ndarray  # (3,) unit, toward azimuth 0
    azimuths_deg: Mapping[int, float]  # view -> 0 to 360
    gaps: tuple[Gap, ...]  # the widest first

    @property
    def widest_deg(self) -> float:
        """The largest angle between neighbours."""
        angles = sorted(self.azimuths_deg.values())
        return max(b - a for a, b in zip(angles, [*angles[1:], angles[0] + 360], strict=True))

    def toward(self, azimuth_deg: np.ndarray) -> np.ndarray:
        """Unit vectors (N, 3) from the axis toward azimuths (N,)."""
        angle = np.radians(azimuth_deg)[:, None]
        return np.cos(angle) * self.forward + np.sin(angle) * np.cross(self.up, self.forward)


def measure_coverage(
    T_0: Mapping[int, np.ndarray], sensor: np.ndarray | None, center: np.ndarray, turntable: Turntable | None
) -> Coverage | None:
    """The coverage of views placed by T_0_i (in capture order), about the turntable's axis, else what cameras call up.

    `sensor` (3,) is where the sensor stands in a view's frame; None: it looks along z from far away. `center` (3,) is
    the object's, in frame {0}. None where it cannot be told: fewer than MIN_VIEWS have an azimuth, or there is neither
    a turntable nor a common up.
    """
    if turntable is None:
        up = find_up(T_0)
    else:
        up, center = turntable.axis, turntable.point
        if up @ _mean_up(T_0) < 0:
            up = -up
    if up is None:
        return None
    level: dict[int, np.ndarray] = {}
    for view, T in T_0.items():
        away = -T[:3, 2] if sensor is None else poses.transform(T, sensor[None])[0] - center
        flat = away - (away @ up) * up
        if np.linalg.norm(flat) > np.sin(np.radians(POLE_DEG)) * np.linalg.norm(away):
            level[view] = flat / np.linalg.norm(flat)
    if len(level) < MIN_VIEWS:
        return None
    forward = next(iter(level.values()))
    left = np.cross(up, forward)
    angles = {view: float(np.degrees(np.arctan2(d @ left, d @ forward))) for view, d in level.items()}
    azimuths = {view: round(angle, 9) % 360 for view, angle in angles.items()}  # rounded: a hair below 0 is not 360
    return Coverage(up, center, forward, azimuths, find_gaps(azimuths))


def find_gaps(azimuths_deg: Mapping[int, float], widest_deg: float = WIDEST_DEG) -> tuple[Gap, ...]:
    """The arcs between neighbouring azimuths that are wider than `widest_deg`, the widest first."""
    ring = sorted(azimuths_deg, key=azimuths_deg.__getitem__)
    gaps = []
    for k, after in enumerate(ring):
        before, turns = (ring[k + 1], 0) if k + 1 < len(ring) else (ring[0], 360)
        gap = Gap(azimuths_deg[after], azimuths_deg[before] + turns, after, before)
        if gap.end_deg - gap.start_deg > widest_deg:
            gaps.append(gap)
    return tuple(sorted(gaps, key=lambda gap: (gap.start_deg - gap.end_deg, gap.start_deg)))


def find_up(T_0: Mapping[int, np.ndarray]) -> np.ndarray | None:
    """The direction (3,) that level cameras call up: square to the x axes of all; None where they share none.

    It is the least singular vector of those axes, whatever the cameras' elevations.
    """
    if len(T_0) < MIN_VIEWS:
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
