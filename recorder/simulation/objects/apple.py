"""Apples: 6 to 9.5 cm, flat to tall, dented at stem and calyx, five-lobed below; standing, leaning, lying."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.fruit import bumps, settled
from orbitscan.recorder.simulation.objects.solids import circle, loft, sweep

LEVELS, SEGMENTS = 45, 64
RED, DARK_RED, PINK, ORANGE = (178, 32, 40), (112, 18, 32), (214, 88, 84), (214, 112, 60)
GREEN, LIME, YELLOW, CREAM = (128, 172, 62), (166, 196, 84), (226, 200, 92), (232, 216, 148)
RUSSET, WOOD = (150, 118, 66), (92, 66, 42)
SKINS = ((RED, YELLOW), (DARK_RED, RED), (RED, LIME), (PINK, CREAM), (ORANGE, YELLOW), (GREEN, LIME), (LIME, YELLOW))
HABITS = {  # least and largest of height over width, taper to the foot, height of the five lobes
    "flat": ((0.72, -0.02, 0.00), (0.83, 0.06, 0.025)),
    "round": ((0.82, 0.00, 0.00), (0.94, 0.09, 0.030)),
    "conic": ((0.86, 0.08, 0.01), (1.00, 0.18, 0.045)),
    "tall": ((0.96, 0.11, 0.03), (1.12, 0.22, 0.070)),
}


def build(rng: np.random.Generator) -> Mesh:
    """An apple; instances differ in habit, size, dents, lobes, bumps, stem (or none), rest and colours."""
    habit = HABITS[("flat", "round", "conic", "tall")[rng.choice(4, p=(0.2, 0.4, 0.2, 0.2))]]
    aspect, taper, lobes = rng.uniform(*habit)
    width = rng.uniform(0.061, 0.093)
    unit = _surface(rng, lobes)
    unit[..., :2] *= 1 + taper * unit[..., 2:]
    unit[..., :2] /= np.ptp(unit[..., :2], axis=(0, 1)).max()
    unit[..., 2] *= aspect / np.ptp(unit[..., 2])
    unit[..., 0] *= rng.uniform(0.93, 1.0)
    unit[..., 0] += rng.uniform(0, 0.13) * unit[..., 2]
    body = loft(width * unit)
    parts = [Mesh(body.vertices, body.triangles, _skin(rng, body.vertices / width))]
    if rng.random() < 0.7:
        parts.append(_stem(rng, width * unit[-1, 0]))
    apple = merge(parts).turned("z", rng.uniform(0, 360))
    tilt = rng.uniform(*((0, 8), (15, 50), (65, 115))[rng.choice(3, p=(0.65, 0.2, 0.15))])
    return settled(apple, tilt, reach_deg=15)


def _surface(rng: np.random.Generator, lobes: float) -> np.ndarray:
    """The rings (LEVELS, SEGMENTS, 3) of an apple of about unit radius, from the calyx up to the stem."""
    share = np.linspace(0, 1, LEVELS)[:, None]
    down = np.pi * (
        share - 0.45 * np.sin(2 * np.pi * share) / (2 * np.pi)
    )  # the angle from the calyx, dense at the dents
    around = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    sine = np.sin(down)
    sine[[0, -1]] = 0
    directions = np.stack([sine * np.cos(around), sine * np.sin(around), -np.cos(down) + 0 * around], axis=-1)
    fullness = rng.uniform(1.9, 2.5)  # 2 is a ball, more is boxy
    radius = (sine**fullness + np.abs(np.cos(down)) ** fullness) ** (-1 / fullness) + 0 * around
    (stem, calyx), (stem_width, calyx_width) = rng.uniform((0.28, 0.14), (0.58, 0.38)), rng.uniform(0.24, 0.46, 2)
    radius -= stem * np.exp(-(((np.pi - down) / stem_width) ** 1.6)) + calyx * np.exp(-((down / calyx_width) ** 1.8))
    five = np.cos(5 * around + rng.uniform(0, 0.5) * np.sin(around + rng.uniform(0, 2 * np.pi)))
    at_foot, at_shoulder = np.exp(-(((down - 0.6) / 0.4) ** 2)), np.exp(-(((np.pi - down - 0.65) / 0.35) ** 2))
    radius += lobes * five * sine * (1.6 * at_foot + rng.uniform(0, 0.9) * at_shoulder)
    radius += bumps(rng, directions, rng.uniform(0.005, 0.028))
    return radius[..., None] * directions


def _skin(rng: np.random.Generator, points: np.ndarray) -> np.ndarray:
    """The colours (V, 3) of points (V, 3) of an apple a unit wide: one cheek blushed, the stem's dent russet."""
    blush, ground = (np.array(color) for color in SKINS[rng.integers(len(SKINS))])
    sun = points @ rng.normal((0, 0, 0.5), (1, 1, 0.3)) * 3 + rng.uniform(-0.5, 1.5)
    streaks = rng.uniform(0, 0.25) * np.sin(rng.integers(14, 24) * np.arctan2(points[:, 1], points[:, 0]))
    colors = ground + np.clip(0.5 + sun + streaks, 0, 1)[:, None] * (blush - ground)
    dent = np.clip(1.4 - np.hypot(points[:, 0], points[:, 1]) / 0.1, 0, 1) * rng.uniform(0.3, 0.9)
    return (colors + dent[:, None] * (RUSSET - colors)).astype(np.uint8)


def _stem(rng: np.random.Generator, foot: np.ndarray) -> Mesh:
    """A stem out of the dent whose bottom is `foot` (3,): thin, thicker at its end, leaning and a little curved."""
    length, radius, lean, curve = rng.uniform((0.010, 0.0008, 0, -0.6), (0.030, 0.0016, 0.5, 0.6))
    along = np.linspace(-0.15, 1, 9)[:, None]
    angles = lean + curve * along
    path = foot + length * along * np.hstack([np.sin(angles), 0 * along, np.cos(angles)])
    return sweep(circle(radius, 10), path, up=(0, 1, 0), scales=1 + 0.5 * along**4).painted(WOOD)
