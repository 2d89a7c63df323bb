"""The cast statue (thesis 5.2): a bust on a plinth, its head turned away, a cloak over one shoulder; no symmetry.

The figure is one skin, found along level rays from its axis in a field of softly joined ellipsoids, in heads.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.solids import box, loft, revolve

BRONZE, PLASTER, MARBLE, CLAY, IRON = (122, 96, 66), (222, 216, 204), (206, 208, 212), (178, 116, 84), (96, 100, 106)
STONES = ((112, 108, 104), (74, 76, 82), (150, 92, 72), (190, 184, 170))
AXIS = -0.04  # x of the level rays' origin [heads]
CUT = -1.50  # height where the bust is cut off; the chin is at -0.5, the crown at 0.5 [heads]
Ellipsoid = tuple[float, float, float, float, float, float, float]  # centre, half axes, nod [degrees]
HEAD: tuple[Ellipsoid, ...] = (
    (-0.09, 0, 0.14, 0.39, 0.32, 0.345, 0),  # skull
    (0.05, 0, -0.10, 0.27, 0.270, 0.36, 0),
    (0.06, 0, -0.32, 0.22, 0.225, 0.15, 0),  # jaw
    (0.220, 0, -0.43, 0.085, 0.100, 0.065, 0),  # chin
    (0.250, 0, 0.085, 0.08, 0.21, 0.045, 0),  # brow
    (0.18, 0.165, -0.10, 0.10, 0.085, 0.08, 0),  # cheeks
    (0.18, -0.165, -0.10, 0.10, 0.085, 0.08, 0),
)
SOCKETS: tuple[Ellipsoid, ...] = (
    (0.345, 0.115, 0.010, 0.080, 0.080, 0.048, 0),
    (0.345, -0.115, 0.010, 0.080, 0.080, 0.048, 0),
)
FEATURES: tuple[Ellipsoid, ...] = (
    (0.262, 0.115, 0.005, 0.045, 0.055, 0.036, 0),  # eyes
    (0.262, -0.115, 0.005, 0.045, 0.055, 0.036, 0),
    (0.325, 0, -0.045, 0.045, 0.038, 0.13, -16),  # nose
    (0.365, 0, -0.125, 0.052, 0.050, 0.042, 0),
    (0.325, 0, -0.140, 0.040, 0.078, 0.034, 0),
    (0.295, 0, -0.240, 0.036, 0.090, 0.022, 0),  # lips
    (0.288, 0, -0.297, 0.036, 0.074, 0.026, 0),
    (-0.03, 0.31, -0.04, 0.085, 0.050, 0.130, 0),  # ears
    (-0.03, -0.31, -0.04, 0.085, 0.050, 0.130, 0),
)
BEARD: tuple[Ellipsoid, ...] = (
    (0.20, 0, -0.47, 0.15, 0.19, 0.20, 0),
    (0.06, 0, -0.36, 0.22, 0.27, 0.17, 0),
    (0.285, 0, -0.205, 0.060, 0.105, 0.025, 0),  # moustache
)
BODY: tuple[Ellipsoid, ...] = (
    (-0.08, 0, -0.55, 0.235, 0.235, 0.40, 12),  # neck
    (-0.10, 0, -0.80, 0.21, 0.54, 0.16, 0),
    (-0.01, 0, -1.22, 0.34, 0.60, 0.50, 0),  # chest
    (-0.06, 0.54, -1.06, 0.27, 0.30, 0.29, 0),  # shoulders
    (-0.06, -0.54, -1.06, 0.27, 0.30, 0.29, 0),
    (0.17, 0.20, -1.17, 0.18, 0.24, 0.19, 0),
    (0.17, -0.20, -1.17, 0.18, 0.24, 0.19, 0),
)


def build(rng: np.random.Generator) -> Mesh:
    """A bust 38 to 46 cm high; instances differ in pose, face, hair and beard, in cloak, plinth and cast."""
    head, plinth = rng.uniform((0.140, 0.050), (0.165, 0.075))
    cast = (BRONZE, PLASTER, MARBLE, CLAY, IRON)[rng.integers(5)]
    stone = STONES[rng.integers(len(STONES))]
    figure = _figure(rng)
    figure = Mesh(head * figure.vertices, figure.triangles).painted(cast)
    low = figure.bounds[0][2]
    neck = head * np.array(
        [(0, 0), (0.36, 0), (0.36, 0.05), (0.26, 0.09), (0.20, 0.17), (0.24, 0.26), (0.30, 0.32), (0, 0.32)]
    )
    foot = 0.92 * head
    parts = [figure.moved(z=plinth + 0.28 * head - low), revolve(neck, 40).moved(z=plinth).painted(cast)]
    if rng.random() < 0.5:
        parts += [
            box(foot, 0.86 * foot, plinth, 0.006).painted(stone),
            box(1.12 * foot, 0.98 * foot, 0.25 * plinth, 0.004).painted(stone),
        ]
    else:
        steps = np.array([(0, 0), (0.60, 0), (0.60, 0.2), (0.54, 0.3), (0.50, 0.75), (0.54, 0.85), (0.54, 1), (0, 1)])
        parts.append(revolve(steps * (foot, plinth), 40).painted(stone))
    return merge(parts)


def _figure(rng: np.random.Generator) -> Mesh:
    """The bust's figure, its lengths in heads."""
    turn_deg, nod_deg, tilt_deg = rng.uniform((14, -6, -7), (32, 10, 7)) * (rng.choice([-1, 1]), 1, 1)
    field = _Field.draw(rng, Rotation.from_euler("zyx", [turn_deg, nod_deg, tilt_deg], degrees=True))
    top = _crown(field)
    levels = np.concatenate(
        [
            np.linspace(CUT, -0.62, 23)[:-1],
            np.linspace(-0.62, top - 0.16, 38)[:-1],
            top - 0.16 * np.array([1, 0.82, 0.65, 0.49, 0.35, 0.22, 0.12, 0.05, 0.012]),
        ]
    )
    twist = np.radians(turn_deg) * PchipInterpolator([CUT, -1.0, -0.45, 1], [0, 0, 1, 1])(levels)
    spread = np.linspace(-1, 1, 64, endpoint=False)
    angle = twist[:, None] + np.pi * (0.7 * spread + 0.3 * spread**3)  # finest in the face
    broad = 1 + PchipInterpolator([CUT, -1.0, -0.55, 1], [1, 1, 0, 0])(levels)[:, None]  # as many rays to the shoulders
    rays = np.stack([np.cos(angle), broad * np.sin(angle), 0 * angle], axis=2)
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    axis = np.column_stack([np.full(len(levels), AXIS), 0 * levels, levels])[:, None]
    reach = np.full(angle.shape, 1.2)
    for _ in range(36):
        reach = np.maximum(reach - 0.8 * field(axis + reach[..., None] * rays), 0.01)
    return loft(axis + reach[..., None] * rays)


def _crown(field: _Field) -> float:
    """The height where the figure's axis leaves the head."""
    z = np.linspace(0.2, 0.8, 600)
    return float(z[field(np.column_stack([np.full(600, AXIS), 0 * z, z])) < 0].max())


@dataclass(frozen=True)
class _Field:
    """About the distance of points (..., 3) from the figure, negative within it."""

    pose: Rotation  # of the head
    face: np.ndarray  # factors on the head's depth, width and height
    hair: float  # its thickness
    curl: np.ndarray  # (3, 3) wave vectors of the hair
    bearded: bool
    shoulder: float  # the one under the cloak: 1 left, -1 right
    folds: np.ndarray  # wave number and phase of the cloak

    @staticmethod
    def draw(rng: np.random.Generator, pose: Rotation) -> _Field:
        """A figure with a face, hair and a cloak drawn from the generator."""
        waves = rng.normal(size=(3, 3))
        return _Field(
            pose=pose,
            face=rng.uniform((0.94, 0.90, 0.96), (1.06, 1.06, 1.03)),
            hair=rng.uniform(0.03, 0.07),
            curl=32 * waves / np.linalg.norm(waves, axis=1, keepdims=True),
            bearded=bool(rng.integers(2)),
            shoulder=rng.choice([-1.0, 1.0]),
            folds=rng.uniform((14, 0), (19, 6)),
        )

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """About the distances (...,) of points (..., 3) from the surface, in heads."""
        head = self.pose.inv().apply(points.reshape(-1, 3)).reshape(points.shape) / self.face
        distance = _join(_union(head, HEAD, 0.06), -_union(head, SOCKETS, 0.02), -0.03)
        distance = _join(distance, _union(head, FEATURES, 0.02), 0.025)
        curls = np.sin(head @ self.curl.T).sum(axis=-1) / 3
        if self.bearded:
            distance = np.minimum(distance, _union(head, BEARD, 0.04) - 0.018 * curls)
        x, _, z = np.moveaxis(head, -1, 0)
        hairline = np.interp(z, [-0.45, -0.15, 0.05, 0.14, 0.30, 0.45], [-0.22, -0.17, -0.02, 0.14, 0.19, 0.6])
        distance = distance - self.hair * (1 + 0.5 * curls) * _step((hairline - x) / 0.06) * _step((z + 0.42) / 0.1)
        body = _union(points, BODY, 0.12)
        x, y, z = np.moveaxis(points, -1, 0)
        over = self.shoulder * y + 0.75 * (z + 1.16) + 0.05 * np.sin(7 * x)
        fold = 0.060 + 0.028 * np.sin(self.folds[0] * (over + 0.25 * x) + self.folds[1])
        body = body - fold * _step(over / 0.10) * _step((-0.71 - z) / 0.08)
        return _join(distance, body, 0.05)


def _union(points: np.ndarray, shapes: tuple[Ellipsoid, ...], blend: float) -> np.ndarray:
    """About the distance of points (..., 3) from the ellipsoids, joined softly over `blend`."""
    distance = None
    for *center, a, b, c, nod_deg in shapes:
        x, y, z = np.moveaxis(points - center, -1, 0)
        cosine, sine = np.cos(np.radians(nod_deg)), np.sin(np.radians(nod_deg))
        x, z = cosine * x - sine * z, sine * x + cosine * z
        near = np.sqrt((x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2) + 1e-9
        steep = np.sqrt((x / a**2) ** 2 + (y / b**2) ** 2 + (z / c**2) ** 2) + 1e-9
        one = near * (near - 1) / steep
        distance = one if distance is None else _join(distance, one, blend)
    assert distance is not None  # there is a shape
    return distance


def _join(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    """The smaller of two distances (the larger where `blend` is negative), rounded over the blend."""
    share = np.clip(0.5 + 0.5 * (b - a) / blend, 0, 1)
    return b + (a - b) * share - blend * share * (1 - share)


def _step(x: np.ndarray) -> np.ndarray:
    """From 0 to 1, smooth, while x goes from -1 to 1."""
    share = np.clip(0.5 + 0.5 * x, 0, 1)
    return share**2 * (3 - 2 * share)
