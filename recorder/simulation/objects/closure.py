"""What closes a bottle: caps, spouts and lids, standing on z = 0; and loops to carry them by, in the plane x = 0."""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.solids import revolve, rounded_rectangle, sweep
from orbitscan.recorder.simulation.objects.vessel import SEGMENTS


def screw_cap(radius: float, height: float, dome: float = 0.0) -> Mesh:
    """A flat cap, or one that rises by `dome` more in the middle [m]."""
    side = [(0, 0), (radius, 0), (radius, 0.85 * height), (0.96 * radius, 0.96 * height), (0.88 * radius, height)]
    turns = np.radians([30, 55, 75]) if dome else ()
    rise = [(0.88 * radius * np.cos(a), height + dome * np.sin(a)) for a in turns]
    return revolve(np.array([*side, *rise, (0, height + dome)]), SEGMENTS)


def sports_cap(radius: float, height: float, spout: float, length: float, waist: float = 0.8) -> Mesh:
    """A cap that narrows to a pull spout of a radius and a length; the spout's stem is `waist` of it wide [m]."""
    skirt = 0.45 * height
    cone = [(radius, 0), (radius, skirt), (0.93 * radius, skirt + 0.003), (1.25 * spout, 0.92 * height)]
    stem = [(waist * spout, height), (waist * spout, height + 0.45 * length), (spout, height + 0.55 * length)]
    tip = [(spout, height + 0.85 * length), (0.75 * spout, height + length), (0, height + length)]
    return revolve(np.array([(0, 0), *cone, *stem, *tip]), SEGMENTS)


def cup_lid(radius: float, height: float, taper: float) -> Mesh:
    """A lid to drink from, upside down: `taper` of its radius wide at the top [m]."""
    top = taper * radius
    profile = [(0, 0), (radius, 0), (top, 0.90 * height), (0.95 * top, 0.97 * height), (0.85 * top, height)]
    return revolve(np.array([*profile, (0, height)]), SEGMENTS)


def carrying_loop(half: float, rise: float, width: float) -> Mesh:
    """A bow over a cap, from y = -half to half, `rise` high and its strap `width` wide [m]."""
    angles = np.linspace(0, np.pi, 25)
    out, up = np.cos(angles), np.sin(angles)
    path = np.column_stack([0 * out, half * np.sign(out) * np.abs(out) ** 0.7, rise * np.abs(up) ** 0.7 - 0.002])
    return sweep(rounded_rectangle(0.005, width, 0.0018, 3), path, up=(1, 0, 0))


def tether(start: tuple[float, float], end: tuple[float, float], reach: float, width: float) -> Mesh:
    """A strap from one point (y, z) to another that bows out towards +y by `reach` [m]."""
    share = np.linspace(0, 1, 21)
    y, z = (a + (b - a) * share for a, b in zip(start, end, strict=True))
    path = np.column_stack([0 * share, y + reach * np.sin(np.pi * share) ** 0.8, z])
    return sweep(rounded_rectangle(0.0035, width, 0.0015, 3), path, up=(1, 0, 0))
