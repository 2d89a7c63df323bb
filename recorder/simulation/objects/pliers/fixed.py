"""Pliers with a fixed joint: long needle noses, diagonal and end cutters, and the small ones for electronics."""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.pliers.lever import (
    Finish,
    crossed,
    finish,
    handle,
    handle_path,
    jaw,
    opening,
)

POINTS = 24  # along a jaw


def needle_nose(rng: np.random.Generator) -> Mesh:
    """Long thin jaws, straight or with their tips bent up."""
    look = finish(rng)
    length, root, tip, head = rng.uniform((0.068, 0.0105, 0.0022, 0.0105), (0.118, 0.0150, 0.0042, 0.0160))
    bend = rng.uniform(0.006, 0.020) if rng.random() < 0.3 else 0.0
    s = np.linspace(-0.08, 1, POINTS)
    rise = bend * np.clip((s - 0.6) / 0.4, 0, 1) ** 1.5
    width = np.interp(s, [-0.08, 0.12, 0.35, 1], [0.8 * root, root, 0.6 * root, tip])
    edge = _jaw_at(length * s + 0.5 * head * (s > 0), width, np.interp(s, [0, 1], [0.0105, 1.3 * tip]), rise)
    return _pair(rng, edge, head, look, rng.uniform((0.095, 0.016), (0.140, 0.030)), 36)


def cutters(rng: np.random.Generator) -> Mesh:
    """Short heads: diagonal cutters with a round back, or end cutters whose edges meet before an arch."""
    look = finish(rng)
    head, handles = rng.uniform(0.0125, 0.0190), rng.uniform((0.085, 0.014), (0.155, 0.030))
    s = np.linspace(0, 1, POINTS)
    if rng.random() < 0.6:
        length, wide = rng.uniform((0.016, 0.013), (0.030, 0.020))
        back = wide * np.sqrt(np.clip(1 - 0.92 * s**2.2, 0, 1))
        x = np.interp(s, [0, 1], [-0.25 * head, head * 0.7 + length])
        edge = _jaw_at(x, np.maximum(back, 0.004), np.interp(s, [0, 0.5, 1], [0.012, 0.011, 0.006]))
    else:
        reach, arch, wide = rng.uniform((0.026, 0.009, 0.007), (0.044, 0.018, 0.011))
        turn = np.pi * s
        x = 0.3 * head + reach * (1 - np.cos(turn)) / 2
        inner = np.column_stack([x, 0.0005 + arch * np.sin(turn) * (s > 0)])
        outer = np.column_stack([x + 0.006 * s**3, inner[:, 1] + wide * np.interp(s, [0, 0.8, 1], [1, 0.9, 0.45])])
        edge = jaw(inner, outer, np.interp(s, [0, 0.4, 1], [0.011, 0.013, rng.uniform(0.015, 0.024)]))
    return _pair(rng, edge, head, look, handles, 34)


def mini(rng: np.random.Generator) -> Mesh:
    """Small pliers of 9 to 13 cm: short nose, round nose or nippers, with slender bowed handles."""
    look = finish(rng)
    length, root, tip, head = rng.uniform((0.014, 0.0070, 0.0018, 0.0075), (0.036, 0.0100, 0.0060, 0.0105))
    s = np.linspace(-0.1, 1, POINTS)
    width = np.interp(s, [-0.1, 0.15, 1], [0.8 * root, root, tip])
    edge = _jaw_at(0.4 * head + length * s, width, np.interp(s, [0, 1], [0.0090, 0.8 * tip + 0.002]))
    return _pair(rng, edge, head, look, rng.uniform((0.066, 0.012), (0.090, 0.022)), 40, 0.0075)


def _jaw_at(x: np.ndarray, width: np.ndarray, heights: np.ndarray, rise: np.ndarray | float = 0.0) -> Mesh:
    """A straight jaw whose inner edge runs along the x axis at the given x, with the widths there [m]."""
    return jaw(np.column_stack([x, np.full(len(x), 0.0004)]), np.column_stack([x, 0.0004 + width]), heights, rise)


def _pair(
    rng: np.random.Generator,
    edge: Mesh,
    head: float,
    look: Finish,
    handles: np.ndarray,
    widest: float,
    width: float = 0.0105,
) -> Mesh:
    """Pliers of two equal levers, from a jaw and the length and bow of the handles; a bent tip bends both jaws up."""
    length, bow = handles
    path = handle_path(length, 0.45 * head, bow, rng.uniform(0, 1), rng.uniform(0, 0.006))
    lever = handle(path, look, width, 0.8 * width)
    other = Mesh(edge.vertices * (1, 1, -1) + (0, 0, 0.012), edge.triangles[:, ::-1])
    jaws = edge.painted(look.metal), other.painted(look.metal)
    return crossed([jaws[0], *lever], [jaws[1], *lever], opening(rng, widest), head, look)
