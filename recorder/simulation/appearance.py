"""How a virtual object looks to a camera: what is painted on it, by which lamp it is lit, and what the sensor adds."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.raycasting import Hits

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

Paint = Literal["own", "plain", "label", "stripe", "print"]
Lamp = Literal["object", "camera", "room"]
PAINTS, LAMPS = get_args(Paint), get_args(Lamp)

BESIDE = np.array([0.36, -0.48, 0.80])  # the direction to a lamp that stands still beside the object
IN_THE_ROOM = np.array([-0.48, -0.64, -0.60])  # to one that stands still while the object turns, in the camera's frame
AMBIENT = 0.6  # share of the light that comes from everywhere
SHARPNESS = 40.0  # Phong's exponent of a highlight

BASE = np.array([178.0, 176.0, 170.0])  # of what is painted
LABEL, STRIPE = np.array([238.0, 236.0, 228.0]), np.array([168.0, 36.0, 40.0])
INKS = np.array([[32, 52, 120], [176, 40, 44], [232, 190, 60], [40, 120, 70], [235, 232, 224], [60, 58, 60]], float)
BACKGROUND = np.array([48.0, 48.0, 52.0])  # what a colour camera sees that looks past the object
STRIPE_DEG, LABEL_DEG = 6.0, 28.0  # half the width, about the object's front
LABEL_FROM, LABEL_TO = 0.25, 0.75  # of the height
COARSE, FINE = 0.16, 0.05  # size of a print's patches, as shares of the object's diagonal
PRINT_SEED = 7


@dataclass(frozen=True, eq=False)
class Appearance:
    """Paint and light of a mesh."""

    mesh: Mesh
    paint: Paint
    lamp: Lamp
    gloss: float  # brightness of a highlight, as a share of white

    @property
    def words(self) -> list[str]:
        """What differs from an object as it is, beside a lamp that stands still."""
        painted = [] if self.paint == "own" else [f"painted: {self.paint}"]
        lit = [] if self.lamp == "object" else [f"lamp {'at the camera' if self.lamp == 'camera' else 'in the room'}"]
        return painted + lit + ([f"gloss {self.gloss:g}"] if self.gloss else [])

    def colors(self, T_object_camera: np.ndarray, directions: np.ndarray, hits: Hits) -> np.ndarray | None:
        """The colours (N, 3), 0 to 255, that a camera sees in directions (N, 3); None where the mesh has none.

        Rays that met nothing show the background.
        """
        met = np.isfinite(hits.distance)
        back, hits = toward(directions[met]), hits.of(met)
        normals = hits.normals * np.sign((back * hits.normals).sum(axis=1))[:, None]
        points = T_object_camera[:3, 3] + hits.distance[:, None] * directions[met]
        painted = self._own(hits) if self.paint == "own" else self._paint(points)
        if painted is None:
            return None
        lamp = {"object": BESIDE, "camera": back, "room": T_object_camera[:3, :3] @ IN_THE_ROOM}[self.lamp]
        colors = np.tile(BACKGROUND, (len(met), 1))
        colors[met] = self._light(painted, normals, back, lamp)
        return colors

    def _light(self, painted: np.ndarray, normals: np.ndarray, back: np.ndarray, lamp: np.ndarray) -> np.ndarray:
        """Colours (N, 3) in a lamp's light from (3,) or (N, 3), seen from (N, 3): diffuse, and Phong's highlights."""
        facing = (normals * lamp).sum(axis=1)
        colors = painted * (AMBIENT + (1 - AMBIENT) * np.clip(facing, 0, 1))[:, None]
        if self.gloss:
            mirrored = 2 * facing[:, None] * normals - lamp
            highlight = np.clip((mirrored * back).sum(axis=1), 0, 1) ** SHARPNESS * (facing > 0)
            colors += 255 * self.gloss * highlight[:, None]
        return colors

    def _own(self, hits: Hits) -> np.ndarray | None:
        """The mesh's colours (N, 3), interpolated between its vertices."""
        if self.mesh.colors is None:
            return None
        corners = self.mesh.colors[self.mesh.triangles[hits.triangles]]  # (N, 3, 3)
        weights = np.column_stack([1 - hits.uv.sum(axis=1), hits.uv])
        return (weights[:, :, None] * corners).sum(axis=1)

    def _paint(self, points: np.ndarray) -> np.ndarray:
        """What is painted at points (N, 3) of the surface: about the front, +x, between heights."""
        low, high = self.mesh.bounds
        center = (low + high) / 2
        azimuth = np.degrees(np.arctan2(points[:, 1] - center[1], points[:, 0] - center[0]))
        height = (points[:, 2] - low[2]) / max(high[2] - low[2], 1e-9)
        colors = np.tile(BASE, (len(points), 1))
        if self.paint == "print":
            return self._print(points)
        if self.paint == "stripe":
            colors[np.abs(azimuth) <= STRIPE_DEG] = STRIPE
        if self.paint == "label":
            on = (np.abs(azimuth) <= LABEL_DEG) & (height >= LABEL_FROM) & (height <= LABEL_TO)
            inked = on & (np.abs(azimuth) <= 0.8 * LABEL_DEG) & (np.abs(height - 0.5) <= 0.2)
            colors[on] = LABEL
            colors[inked] = self._print(points[inked])
        return colors

    def _print(self, points: np.ndarray) -> np.ndarray:
        """Patches of ink (Worley's cells), large ones with small ones of other brightness on them."""
        coarse, fine = self._cells
        ink = INKS[coarse.query(points)[1] % len(INKS)]
        dark = np.where(fine.query(points)[1] % 3 == 0, 0.55, 1.0)
        return ink * dark[:, None]

    @cached_property
    def _cells(self) -> tuple[cKDTree, cKDTree]:
        from scipy.spatial import cKDTree  # half a second

        low, high = self.mesh.bounds
        generator = np.random.default_rng(PRINT_SEED)
        size = float(np.linalg.norm(high - low))
        trees = []
        for share in (COARSE, FINE):
            cells = np.ceil((high - low) / (share * size)).astype(int) + 2
            grid = np.stack(np.meshgrid(*map(np.arange, cells), indexing="ij"), axis=-1).reshape(-1, 3)
            corners = grid - 1 + generator.random(grid.shape)
            trees.append(cKDTree(low + corners[generator.permutation(len(corners))] * share * size))
        return trees[0], trees[1]


def toward(directions: np.ndarray) -> np.ndarray:
    """Unit vectors (N, 3) back along rays (N, 3)."""
    return -directions / np.linalg.norm(directions, axis=1, keepdims=True)


def add_noise(colors: np.ndarray, deviation: float, rng: np.random.Generator) -> np.ndarray:
    """Colours (N, 3) uint8 as a sensor gives them: every channel off by a standard deviation, of 255."""
    if deviation:
        colors = colors + deviation * rng.standard_normal(colors.shape)
    return np.clip(np.rint(colors), 0, 255).astype(np.uint8)
