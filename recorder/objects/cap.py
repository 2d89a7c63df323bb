"""Baseball caps as they lie on a table: a crown of six panels with a button, a curved brim, a strap behind."""

from dataclasses import dataclass

import numpy as np

from recorder.objects.mesh import Mesh, merge
from recorder.objects.solids import cylinder, ellipsoid, loft, rounded_rectangle, sweep

NAVY, RED, BLACK, GREEN = (44, 56, 98), (182, 48, 46), (62, 62, 66), (62, 104, 78)
KHAKI, WHITE, GREY, ORANGE, SKY = (188, 168, 128), (234, 232, 224), (136, 140, 146), (226, 132, 50), (104, 152, 200)
CLOTHS = (NAVY, RED, BLACK, GREEN, KHAKI, WHITE, GREY, ORANGE, SKY)
BAND = (92, 88, 84)
SEGMENTS = 96  # around the crown, 16 for a panel
THICKNESS = 0.0025  # of the crown [m]
BEARING = 1.0  # from the front, where the brim ends on either side [rad]


def build(rng: np.random.Generator) -> Mesh:
    """A cap about 27 cm long; instances differ in crown, brim, emblem and cloths."""
    crown = _Crown(*rng.uniform((0.092, 0.074, 0.102, 0.55, 0.016), (0.102, 0.084, 0.124, 0.80, 0.036)))
    main, second, accent = (CLOTHS[i] for i in rng.permutation(len(CLOTHS))[:3])
    front = accent if rng.random() < 0.3 else main
    trim = second if rng.random() < 0.7 else main
    parts = [
        _shell(crown, main, front),
        _brim(crown, rng.uniform(0.064, 0.078)).painted(trim),
        ellipsoid(0.0075, 0.0075, 0.004, 16).moved(z=crown.height + 0.001).painted(second),
        _emblem(rng, crown).painted(second if front == WHITE else WHITE),
        _strap(crown).painted(trim),
        *(part.painted(second) for part in _eyelets(crown)),
    ]
    return merge(parts)


@dataclass(frozen=True)
class _Crown:
    """The surface of the crown, its half axes and height [m]."""

    length: float
    width: float
    height: float
    boxiness: float
    bend: float  # of the brim, and so of the edge it is sewn to [m]

    def at(self, angle: np.ndarray, share: np.ndarray, grown: float = 0.0) -> np.ndarray:
        """Points (..., 3) at an angle [rad] from the front, `share` of the way up, all `grown` outward [m]."""
        angle, share = np.broadcast_arrays(angle, share)
        rise = np.clip(share, 0, 1) * np.pi / 2
        out = np.where(share < 1, np.cos(rise), 0) ** self.boxiness
        up = np.sin(rise) ** (0.95 - 0.12 * np.cos(angle))  # the front panels stand steeper
        lift = self.bend * np.clip(1 - (np.sin(angle) / np.sin(BEARING)) ** 2, 0, 1) * (np.cos(angle) > 0)
        x = (self.length + grown) * out * np.cos(angle)
        y = (self.width + grown) * out * np.sin(angle)
        return np.stack([x, y, (self.height + grown) * up + lift * (1 - share)], axis=-1)


def _shell(crown: _Crown, color: tuple[int, int, int], front: tuple[int, int, int]) -> Mesh:
    """The hollow crown, seams between its panels and an arch cut out above the strap."""
    angle = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    edge = 0.30 * np.sqrt(np.clip(1 - ((np.pi - angle) / 0.42) ** 2, 0, 1))
    levels = np.concatenate([np.linspace(0, 0.8, 13), [0.86, 0.91, 0.95, 0.98, 1]])[:, None]
    share = edge + (1 - edge) * levels
    seam = (np.arange(SEGMENTS) % (SEGMENTS // 6) == 0) * np.minimum(1, 8 * (1 - levels))
    outside = crown.at(angle, share) * (1 - 0.012 * seam[..., None])
    inside = crown.at(angle, share, -THICKNESS)[::3]
    mesh = loft(np.concatenate([inside[::-1], outside]))
    lined = (len(inside) - 1) * SEGMENTS
    colors = np.where((np.cos(angle) > 0.49)[:, None], np.array(front), np.array(color))
    painted = np.tile(colors, (len(mesh.vertices) // SEGMENTS, 1))
    painted[:lined] = BAND
    return Mesh(mesh.vertices, mesh.triangles, np.concatenate([painted, [BAND, color]]).astype(np.uint8))


def _brim(crown: _Crown, reach: float) -> Mesh:
    """The brim: a sheet from the crown's edge to an arc `reach` before it, bent down at its sides."""
    across = np.linspace(-1, 1, 41)
    inner = crown.at(BEARING * across, 0, -0.004)
    sewn = inner[:, 0].min()
    arc = sewn + (inner[:, 0].max() - sewn + reach) * np.sqrt(1 - np.abs(across) ** 2.3)
    outer = np.column_stack([np.maximum(arc, inner[:, 0] + 0.005), 1.04 * inner[:, 1], inner[:, 2] - 0.004])
    half = np.array([0, 0, 0.002])
    top = inner + np.linspace(0, 1, 6)[:, None, None] * (outer - inner)
    return loft(np.concatenate([top + half, top[::-1] - half]).transpose(1, 0, 2))


def _emblem(rng: np.random.Generator, crown: _Crown) -> Mesh:
    """A patch sewn on the front panels: a disc, a star, a shield or a clover."""
    points = int(rng.choice([0, 3, 4, 5]))
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    radius = rng.uniform(0.85, 1.10) * (1 + (0.25 if points else 0) * np.cos(points * (turn - np.pi / 2)))
    across, up = 0.26 * radius * np.cos(turn), 0.15 * radius * np.sin(turn)
    layers = [(-0.002, 1), (0.0015, 1), (0.0025, 0.92), (0.0025, 0.6), (0.0025, 0.3)]
    return loft(np.stack([crown.at(k * across, 0.36 + k * up, grown) for grown, k in layers]))


def _strap(crown: _Crown) -> Mesh:
    """The strap that closes the arch behind."""
    path = crown.at(np.linspace(np.pi - 0.5, np.pi + 0.5, 17), 0, -0.001)
    return sweep(rounded_rectangle(0.003, 0.017, 0.001, 2), path + np.array([0, 0, 0.009]))


def _eyelets(crown: _Crown) -> list[Mesh]:
    """A sewn hole high in every panel."""
    ring = cylinder(0.0045, 0.003, 0.001, 14).moved(z=-0.001).turned("y", 50)
    bearings = range(30, 390, 60)
    return [ring.turned("z", degrees).moved(*crown.at(np.radians(degrees), 0.62)) for degrees in bearings]
