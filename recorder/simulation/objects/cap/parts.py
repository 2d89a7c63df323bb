"""What caps are sewn of, all of it placed on a crown: the shell of panels, the brim, emblem, strap and eyelets."""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.cap.crown import BEARING, Crown
from orbitscan.recorder.simulation.objects.solids import cylinder, loft, rounded_rectangle, sweep

BAND = (92, 88, 84)
SEGMENTS = 96  # around the crown, 16 for a panel
THICKNESS = 0.0025  # of the crown [m]


def shell(crown: Crown, color: tuple[int, int, int], front: tuple[int, int, int]) -> Mesh:
    """The hollow crown, seams between its panels and an arch cut out above the strap."""
    angle = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    edge = crown.arch * np.sqrt(np.clip(1 - ((np.pi - angle) / 0.42) ** 2, 0, 1))
    levels = np.concatenate([np.linspace(0, 0.8, 13), [0.86, 0.91, 0.95, 0.98, 1]])[:, None]
    share = edge + (1 - edge) * levels
    seam = (np.arange(SEGMENTS) % (SEGMENTS // 6) == 0) * np.minimum(1, 8 * (1 - levels))
    outside = crown.at(angle, share) * (1 - 0.012 * seam[..., None])
    inside = crown.at(angle, share, -THICKNESS)[:: 2 if crown.dents else 3]
    mesh = loft(np.concatenate([inside[::-1], outside]))
    lined = (len(inside) - 1) * SEGMENTS
    colors = np.where((np.cos(angle) > 0.49)[:, None], np.array(front), np.array(color))
    painted = np.tile(colors, (len(mesh.vertices) // SEGMENTS, 1))
    painted[:lined] = BAND
    return Mesh(mesh.vertices, mesh.triangles, np.concatenate([painted, [BAND, color]]).astype(np.uint8))


def brim(crown: Crown, reach: float, rise: float = 0.0, curl: float = 0.0, square: float = 2.3) -> Mesh:
    """The brim: a sheet from the crown's edge to an arc `reach` before it, bent down at its sides.

    It goes up by `rise` [m] towards its front (down if negative), its sides go down by `curl` [m]; the arc's corners
    are the squarer, the higher the exponent.
    """
    across = np.linspace(-1, 1, 41)
    inner = crown.at(BEARING * across, 0, -0.004)
    sewn = inner[:, 0].min()
    arc = sewn + (inner[:, 0].max() - sewn + reach) * np.sqrt(1 - np.abs(across) ** square)
    outer = np.column_stack([np.maximum(arc, inner[:, 0] + 0.005), 1.04 * inner[:, 1], inner[:, 2] - 0.004])
    share = np.linspace(0, 1, 6)[:, None, None]
    top = inner + share * (outer - inner)
    ahead = (top[..., 0] - inner[:, 0]) / reach
    top[..., 2] += rise * ahead - curl * across**2 * share[..., 0]
    half = np.array([0, 0, 0.002])
    return loft(np.concatenate([top + half, top[::-1] - half]).transpose(1, 0, 2))


def emblem(rng: np.random.Generator, crown: Crown) -> Mesh:
    """A patch sewn on the front panels: a disc, a star, a shield or a clover."""
    points = int(rng.choice([0, 3, 4, 5]))
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    radius = rng.uniform(0.85, 1.10) * (1 + (0.25 if points else 0) * np.cos(points * (turn - np.pi / 2)))
    across, up = 0.26 * radius * np.cos(turn), 0.15 * radius * np.sin(turn)
    layers = [(-0.002, 1), (0.0015, 1), (0.0025, 0.92), (0.0025, 0.6), (0.0025, 0.3)]
    return loft(np.stack([crown.at(k * across, 0.36 + k * up, grown) for grown, k in layers]))


def strap(crown: Crown) -> Mesh:
    """The strap that closes the arch behind."""
    path = crown.at(np.linspace(np.pi - 0.5, np.pi + 0.5, 17), 0, -0.001)
    return sweep(rounded_rectangle(0.003, 0.017, 0.001, 2), path + np.array([0, 0, 0.009]))


def eyelets(crown: Crown) -> list[Mesh]:
    """A sewn hole high in every panel."""
    ring = cylinder(0.0045, 0.003, 0.001, 14).moved(z=-0.001).turned("y", 50)
    bearings = range(30, 390, 60)
    return [ring.turned("z", degrees).moved(*crown.at(np.radians(degrees), 0.62)) for degrees in bearings]
