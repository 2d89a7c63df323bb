"""A triangle mesh, and the moves it is put together with."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in metres; where closed, they are counterclockwise seen from outside."""

    vertices: np.ndarray  # (V, 3) float64
    triangles: np.ndarray  # (T, 3) int64
    colors: np.ndarray | None = None  # (V, 3) uint8 RGB

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """The corners (3,) of the box around the mesh: the lowest and the highest x, y, z [m]."""
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    @property
    def volume(self) -> float:
        """The volume [m^3] within a closed mesh (parts that overlap count twice); negative where it is inside out."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return float(np.einsum("ti,ti->", a, np.cross(b, c)) / 6)

    def moved(self, x: float = 0, y: float = 0, z: float = 0) -> Mesh:
        """A copy of the mesh, shifted by x, y, z [m]."""
        return replace(self, vertices=self.vertices + np.array([x, y, z]))

    def turned(self, axis: str, degrees: float) -> Mesh:
        """A copy of the mesh, turned about the origin's axis `x`, `y` or `z` by the right-hand rule."""
        return replace(self, vertices=Rotation.from_euler(axis, degrees, degrees=True).apply(self.vertices))

    def painted(self, color: tuple[int, int, int]) -> Mesh:
        """A copy of the mesh in one RGB colour."""
        return replace(self, colors=np.tile(np.array(color, np.uint8), (len(self.vertices), 1)))


def merge(parts: Iterable[Mesh]) -> Mesh:
    """The painted parts as one mesh; they may overlap, what lies inside another is simply never seen."""
    parts = list(parts)
    starts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    return Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=True)]),
        np.concatenate([part.colors for part in parts]),
    )
