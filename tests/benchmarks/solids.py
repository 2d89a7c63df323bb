"""Solids that repeat themselves: prisms, gears, fluted cylinders and boxes, with their orders about the vertical axis.

All stand on z = 0, with the axis of their symmetry on z; metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orbitscan.recorder.mesh import Mesh

Floats = Sequence[float] | np.ndarray
_TURN = np.radians(7.0)  # of every outline about z: no view of a turn in even steps looks at a side squarely
_FLANK = 0.05  # of a gear's pitch, taken by each of a tooth's two flanks
_ARC = 4  # corners on a tooth's tip, and as many between two teeth
_RIB = 24  # corners of a rib and its groove


@dataclass(frozen=True, eq=False)
class Solid:
    """An upright solid of one cross-section; a turn by 360 / order degrees about z, and no smaller one, is unseen."""

    name: str
    family: str
    order: int
    outline: np.ndarray  # (N, 2) corners, counterclockwise [m]
    height: float  # [m]

    @property
    def relief(self) -> float:
        """By how much the outline's distance from the axis varies [m]: what noise must not hide."""
        ends = np.roll(self.outline, -1, axis=0)
        sides = ends - self.outline
        along = -(self.outline * sides).sum(axis=1) / (sides**2).sum(axis=1)
        nearest = self.outline + np.clip(along, 0, 1)[:, None] * sides
        return float(np.linalg.norm(self.outline, axis=1).max() - np.linalg.norm(nearest, axis=1).min())

    def mesh(self) -> Mesh:
        """The closed surface: walls, a lid and a bottom; the two are fans about the axis."""
        n = len(self.outline)
        low, up = np.column_stack([self.outline, np.zeros(n)]), np.array([0, 0, self.height])
        vertices = np.vstack([low, low + up, np.zeros(3), up])
        here = np.arange(n)
        after, bottom, top = (here + 1) % n, np.full(n, 2 * n), np.full(n, 2 * n + 1)
        corners = (
            (here, after, n + after),
            (here, n + after, n + here),
            (bottom, after, here),
            (top, n + here, n + after),
        )
        return Mesh(vertices, np.vstack([np.column_stack(three) for three in corners]).astype(np.int64))

    def write(self, folder: Path) -> Path:
        """The mesh as an OBJ file of the solid's name in a folder."""
        mesh, path = self.mesh(), folder / f"{self.name}.obj"
        lines = [f"v {x:.9f} {y:.9f} {z:.9f}" for x, y, z in mesh.vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in mesh.triangles + 1]
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        return path


def _repeated(order: int, shares: Floats, radii: Floats) -> np.ndarray:
    """(order * N, 2): the outline whose N corners, at shares of a pitch and at radii, come `order` times."""
    angles = _TURN + 2 * np.pi / order * (np.arange(order)[:, None] + np.asarray(shares)).ravel()
    return np.tile(radii, order)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


def _prism(sides: int) -> Solid:
    return Solid(f"prism{sides:02d}", "prisms", sides, _repeated(sides, [0.0], [0.05]), 0.1)


def _gear(teeth: int) -> Solid:
    """A tooth is as wide as the gap after it; the mean radius is 60 mm, the teeth are 8 mm deep."""
    arc = np.linspace(0, 0.5 - _FLANK, _ARC)
    outline = _repeated(teeth, [*arc, *(0.5 + arc)], [0.056] * _ARC + [0.064] * _ARC)
    return Solid(f"gear{teeth:02d}", "gears", teeth, outline, 0.05)


def _flutes(ribs: int) -> Solid:
    """A cylinder of 50 mm with a wave of 4 mm out and 4 mm in."""
    shares = np.arange(_RIB) / _RIB
    return Solid(
        f"flute{ribs:02d}", "flutes", ribs, _repeated(ribs, shares, 0.05 + 0.004 * np.cos(2 * np.pi * shares)), 0.1
    )


def _box(name: str, x: float, y: float, z: float) -> Solid:
    corners = np.array([(-x, -y), (x, -y), (x, y), (-x, y)]) / 2
    turn = np.array([(np.cos(_TURN), -np.sin(_TURN)), (np.sin(_TURN), np.cos(_TURN))])
    return Solid(name, "boxes", 4 if x == y else 2, corners @ turn.T, z)


SOLIDS = {
    solid.name: solid
    for solid in (
        *map(_prism, (3, 4, 5, 6, 8, 12, 24)),
        *map(_gear, (6, 9, 12, 18, 24)),
        *map(_flutes, (8, 12, 18)),
        _box("box", 0.12, 0.08, 0.05),
        _box("carton", 0.07, 0.07, 0.20),
        _box("cube", 0.1, 0.1, 0.1),
        _box("plate", 0.25, 0.15, 0.004),
    )
}
