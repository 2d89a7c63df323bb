"""Where the object stands in frame {0}, and the eyes that look at it."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import rerun.blueprint as rrb

FARTHEST_SENSOR = 3.0  # object diameters from the object at which a range scanner's frustum is drawn
EYE_AZIMUTH_DEG = 25.0  # of the eye, to the right of camera {0}


@dataclass(frozen=True, eq=False)
class Scene:
    """Where the object stands in frame {0}, which way is up, and where views are drawn to be taken from; metres."""

    center: np.ndarray  # (3,)
    diameter: float
    up: np.ndarray  # (3,), unit
    sensor: np.ndarray | None  # (3,) where a view's frustum stands in the view's frame; None where that is unknown

    @classmethod
    def around(
        cls, points: np.ndarray, elevation_deg: float | None, sensor_origin: tuple[float, float, float] | None
    ) -> Self:
        """The scene of an object whose first view, points (N, 3), looks down on it by `elevation_deg`, if known.

        A view shows the front: the object is taken to be as deep as it is wide. A range scanner's origin is far from
        its frame's: its frustum stands nearer, in the same direction.
        """
        low, high = np.percentile(points, [1, 99], axis=0)
        width = max(float((high - low)[:2].max()), 1e-6)
        center = np.array([*(low + high)[:2] / 2, low[2] + width / 2])
        elevation = np.radians(elevation_deg or 0.0)
        diameter = 1.3 * width
        sensor = None if sensor_origin is None else np.array(sensor_origin)
        if sensor is not None and sensor.any():
            offset = sensor - center
            distance, reach = float(np.linalg.norm(offset)), FARTHEST_SENSOR * diameter
            sensor = center + offset * min(1.0, reach / max(distance, 1e-12))
        return cls(center, diameter, np.array([0.0, -np.cos(elevation), -np.sin(elevation)]), sensor)

    def foot(self, axis: np.ndarray, point: np.ndarray) -> np.ndarray:
        """The point (3,) nearest to the object's centre of a line along a unit axis."""
        return point + np.dot(self.center - point, axis) * axis

    def eye(self) -> rrb.EyeControls3D:
        """An eye behind camera {0}, a little to its right: the object fills the view."""
        return self._look(2.9 * self.diameter, height_deg=35)

    def eye_on_all(self) -> rrb.EyeControls3D:
        """An eye from so far above that the frusta all round are in its view."""
        ring = self.diameter if self.sensor is None else float(np.linalg.norm(self.sensor - self.center))
        return self._look(max(2.9 * self.diameter, 2.5 * ring), height_deg=55)

    def beside(self) -> np.ndarray:
        """The unit vector (3,) to the right as those eyes see it, level."""
        right, forward = self._level()
        azimuth = np.radians(EYE_AZIMUTH_DEG)
        return np.cos(azimuth) * right + np.sin(azimuth) * forward

    def _look(self, distance: float, height_deg: float) -> rrb.EyeControls3D:
        right, forward = self._level()
        azimuth, height = np.radians(EYE_AZIMUTH_DEG), np.radians(height_deg)
        level = np.sin(azimuth) * right - np.cos(azimuth) * forward
        position = self.center + distance * (np.cos(height) * level + np.sin(height) * self.up)
        return rrb.EyeControls3D(position=position, look_target=self.center, eye_up=self.up)

    def _level(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors (3,) perpendicular to up: to the right of camera {0}, and away from it."""
        return np.array([1.0, 0.0, 0.0]), np.array([0.0, self.up[2], -self.up[1]])
