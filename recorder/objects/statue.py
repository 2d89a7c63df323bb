"""The cast statue (thesis 5.2): a bust on a plinth, its head turned away, a cloak over one shoulder; no symmetry.

The figure is one skin, found along level rays from its axis in a field of softly joined ellipsoids, in heads.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from recorder.objects.mesh import Mesh, merge
from recorder.objects.solids import box, loft, revolve

BRONZE, PLASTER, MARBLE, CLAY, IRON = (122, 96, 66), (222, 216, 204), (206, 208, 212), (178, 116, 84), (96, 100, 106)
STONES = ((112, 108, 104), (74, 76, 82), (150, 92, 72), (190, 184, 170))
AXIS = -0.04  # x of the level rays' origin [heads]
CUT = -1.62  # height where the bust is cut off; the chin is at -0.5, the crown at 0.5 [heads]
Ellipsoid = tuple[float, float, float, float, float, float, float]  # centre, half axes, nod [degrees]
HEAD: tuple[Ellipsoid, ...] = (
    (-0.09, 0, 0.15, 0.39, 0.31, 0.335, 0),  # skull
    (0.06, 0, -0.10, 0.26, 0.245, 0.36, 0),
    (0.08, 0, -0.33, 0.20, 0.19, 0.14, 0),  # jaw
    (0.235, 0, -0.43, 0.075, 0.085, 0.06, 0),  # chin
    (0.255, 0, 0.085, 0.08, 0.20, 0.045, 0),  # brow
    (0.19, 0.155, -0.09, 0.10, 0.075, 0.07, 0),
    (0.19, -0.155, -0.09, 0.10, 0.075, 0.07, 0),
)
SOCKETS: tuple[Ellipsoid, ...] = (
    (0.345, 0.105, 0.015, 0.085, 0.080, 0.050, 0),
    (0.345, -0.105, 0.015, 0.085, 0.080, 0.050, 0),
)
FEATURES: tuple[Ellipsoid, ...] = (
    (0.262, 0.105, 0.010, 0.045, 0.052, 0.036, 0),  # eyes
    (0.262, -0.105, 0.010, 0.045, 0.052, 0.036, 0),
    (0.335, 0, -0.045, 0.035, 0.035, 0.13, -18),  # nose
    (0.385, 0, -0.125, 0.055, 0.045, 0.04, 0),
    (0.345, 0, -0.145, 0.035, 0.070, 0.028, 0),
    (0.305, 0, -0.240, 0.040, 0.085, 0.020, 0),  # lips
    (0.295, 0, -0.295, 0.040, 0.070, 0.022, 0),
    (-0.03, 0.30, -0.03, 0.085, 0.045, 0.135, 0),  # ears
    (-0.03, -0.30, -0.03, 0.085, 0.045, 0.135, 0),
)
BODY: tuple[Ellipsoid, ...] = (
    (-0.10, 0, -0.62, 0.19, 0.185, 0.42, 12),  # neck
    (-0.12, 0, -0.94, 0.20, 0.50, 0.16, 0),
    (0.0, 0, -1.35, 0.33, 0.56, 0.50, 0),  # chest
    (-0.07, 0.58, -1.20, 0.25, 0.25, 0.27, 0),  # shoulders
    (-0.07, -0.58, -1.20, 0.25, 0.25, 0.27, 0),
    (0.19, 0.20, -1.36, 0.17, 0.22, 0.17, 0),
    (0.19, -0.20, -1.36, 0.17, 0.22, 0.17, 0),
)


def build(rng: np.random.Generator) -> Mesh:
    """A bust 34 to 50 cm high; instances differ in pose, face, hair or beard, in shoulders, cloak, plinth and cast."""
    head, plinth = rng.uniform((0.140, 0.050), (0.165, 0.075))
    cast = (BRONZE, PLASTER, MARBLE, CLAY, IRON)[rng.integers(5)]
    stone = STONES[rng.integers(len(STONES))]
    figure = _figure(rng)
    shaded = np.clip(np.array(cast) * (0.90 + 0.10 * figure.colors[:, :1] / 255), 0, 255).astype(np.uint8)
    figure = Mesh(head * figure.vertices, figure.triangles, shaded)
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
    """The bust in heads, its darkest paint in the folds."""
    turn_deg, nod_deg, tilt_deg = rng.uniform((14, -6, -7), (32, 10, 7)) * (rng.choice([-1, 1]), 1, 1)
    field = _Field.draw(rng, Rotation.from_euler("zyx", [turn_deg, nod_deg, tilt_deg], degrees=True))
    top = _crown(field)
    levels = np.concatenate(
        [
            np.linspace(CUT, -0.62, 18)[:-1],
            np.linspace(-0.62, top - 0.16, 38)[:-1],
            top - 0.16 * np.array([1, 0.82, 0.65, 0.49, 0.35, 0.22, 0.12, 0.05, 0.012]),
        ]
    )
    twist = np.radians(turn_deg) * PchipInterpolator([CUT, -1.1, -0.45, 1], [0, 0, 1, 1])(levels)
    spread = np.linspace(-1, 1, 64, endpoint=False)
    angle = twist[:, None] + np.pi * (0.6 * spread + 0.4 * spread**3)  # finest in the face
    rays = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=2)
    axis = np.column_stack([np.full(len(levels), AXIS), 0 * levels, levels])[:, None]
    reach = np.full(angle.shape, 1.2)
    for _ in range(30):
        reach = np.maximum(reach - 0.8 * field(axis + reach[..., None] * rays), 0.01)
    return loft(axis + reach[..., None] * rays).painted((255, 255, 255))


def _crown(field: "_Field") -> float:
    """The height where the figure's axis leaves the head."""
    z = np.linspace(0.2, 0.8, 600)
    return float(z[field(np.column_stack([np.full(600, AXIS), 0 * z, z])) < 0].max())


@dataclass(frozen=True)
class _Field:
    """About the distance of points (..., 3) from the figure, negative within it."""

    pose: Rotation  # of the head
    face: np.ndarray  # factor on the half axes of the head's ellipsoids
    hair: float  # its thickness
    curl: np.ndarray  # (3, 3) wave vectors of the hair
    beard: float  # 0 to 1
    shoulder: float  # the one under the cloak: 1 left, -1 right
    folds: np.ndarray  # wave number and phase of the cloak

    @staticmethod
    def draw(rng: np.random.Generator, pose: Rotation) -> "_Field":
        """Another face, hair and cloak."""
        return _Field(
            pose=pose,
            face=rng.uniform((0.94, 0.90, 0.96), (1.06, 1.06, 1.03)),
            hair=rng.uniform(0.03, 0.075),
            curl=rng.uniform(-1, 1, (3, 3)) * 16,
            beard=float(rng.integers(2)) * rng.uniform(0.7, 1),
            shoulder=rng.choice([-1.0, 1.0]),
            folds=rng.uniform((24, 0), (32, 6)),
        )

    def __call__(self, points: np.ndarray) -> np.ndarray:
        head = self.pose.inv().apply(points.reshape(-1, 3)).reshape(points.shape)
        distance = _join(_union(head, HEAD, 0.06), -_union(head, SOCKETS, 0.02), -0.03)
        distance = _join(distance, _union(head, FEATURES, 0.02), 0.025)
        x, y, z = np.moveaxis(head, -1, 0)
        waves = np.sin(head @ self.curl.T).sum(axis=-1) / 3
        covered = _step((0.13 - x + 0.9 * np.maximum(z - 0.28, 0) - 1.2 * np.maximum(-0.05 - z, 0)) / 0.05)
        distance = distance - covered * _step((z + 0.32) / 0.1) * self.hair * (1 + 0.45 * waves)
        if self.beard:
            bearded = (
                _step((-0.20 - z) / 0.06)
                * _step((x - 0.02) / 0.08)
                * _step((np.hypot(y / 0.10, (z + 0.27) / 0.05) - 1) / 0.4)
            )
            distance = distance - bearded * self.beard * (0.06 + 0.025 * waves)
        body = _union(points, BODY, 0.07)
        x, y, z = np.moveaxis(points, -1, 0)
        over = self.shoulder * y + 0.75 * (z + 1.28) + 0.06 * np.sin(9 * x)
        fold = 0.060 + 0.022 * np.sin(self.folds[0] * (over + 0.25 * x) + self.folds[1])
        body = body - fold * _step(over / 0.05) * _step((-0.86 - z) / 0.08)
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
    return distance


def _join(a: np.ndarray, b: np.ndarray, blend: float) -> np.ndarray:
    """The smaller of two distances (the larger where `blend` is negative), rounded over the blend."""
    share = np.clip(0.5 + 0.5 * (b - a) / blend, 0, 1)
    return b + (a - b) * share - blend * share * (1 - share)


def _step(x: np.ndarray) -> np.ndarray:
    """From 0 to 1, smooth, while x goes from -1 to 1."""
    share = np.clip(0.5 + 0.5 * x, 0, 1)
    return share**2 * (3 - 2 * share)
