"""The surface of a cap's crown: what all its parts are placed on, dents included."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

BEARING = 1.0  # from the front, where the brim ends on either side [rad]


@dataclass(frozen=True, eq=False)
class Dent:
    """Cloth pushed aside: by `push` at its centre [m], less and less around it."""

    center: np.ndarray  # (3,) [m]
    push: np.ndarray  # (3,) [m]
    radius: float  # standard deviation [m]

    def press(self, points: np.ndarray) -> np.ndarray:
        """The points (..., 3), pushed in by the dent."""
        near = np.exp(-((points - self.center) ** 2).sum(axis=-1, keepdims=True) / (2 * self.radius**2))
        return points + near * self.push


@dataclass(frozen=True)
class Crown:
    """The surface of the crown, its half axes and height [m]."""

    length: float
    width: float
    height: float
    boxiness: float
    bend: float  # of the brim, and so of the edge it is sewn to [m]
    steepness: float = 0.12  # of the front panels above the others
    arch: float = field(default=0.30, kw_only=True)  # cut out above the strap, as a share of the way up
    dents: tuple[Dent, ...] = field(default=(), kw_only=True)

    def at(self, angle: np.ndarray | float, share: np.ndarray | float, grown: float = 0.0) -> np.ndarray:
        """Points (..., 3) at an angle [rad] from the front, `share` of the way up, all `grown` outward [m]."""
        angle, share = np.broadcast_arrays(angle, share)
        rise = np.clip(share, 0, 1) * np.pi / 2
        out = np.where(share < 1, np.cos(rise), 0) ** self.boxiness
        up = np.sin(rise) ** (0.95 - self.steepness * np.cos(angle))  # the front panels stand steeper
        lift = self.bend * np.clip(1 - (np.sin(angle) / np.sin(BEARING)) ** 2, 0, 1) * (np.cos(angle) > 0)
        x = (self.length + grown) * out * np.cos(angle)
        y = (self.width + grown) * out * np.sin(angle)
        points = np.stack([x, y, (self.height + grown) * up + lift * (1 - share)], axis=-1)
        for dent in self.dents:
            points = dent.press(points)
        return points

    def dented(self, rng: np.random.Generator, count: int | np.integer, depth: tuple[float, float]) -> Crown:
        """The crown with so many dents more, each pushed inward by some `depth` [m] anywhere above its edge."""
        dents = []
        for angle, share, push, radius in rng.uniform(
            (0, 0.12, depth[0], 1.3), (2 * np.pi, 1, depth[1], 2.6), (count, 4)
        ):
            center = self.at(np.array(angle), np.array(share))
            inward = (0, 0, 0.35 * self.height) - center
            dents.append(Dent(center, push * inward / np.linalg.norm(inward), max(radius * push, 0.018)))
        return replace(self, dents=(*self.dents, *dents))
