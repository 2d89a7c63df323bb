"""Bell peppers: three or four furrowed lobes, blocky to pointed, a sunken top, a thick stem; standing or lying."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.fruit import bumps, settled
from orbitscan.recorder.simulation.objects.solids import circle, loft, sweep

LEVELS, SEGMENTS = 45, 72
RED, YELLOW, ORANGE, GREEN, LIME = (186, 28, 30), (236, 186, 40), (226, 112, 30), (46, 104, 42), (104, 150, 62)
STEMS = ((84, 126, 58), (106, 142, 76), (122, 130, 72))
HABITS = {  # least and largest of length [m], width over length, taper to the tip, squareness, sinking of the tip
    "blocky": ((0.070, 0.80, 0.00, 0.55, 0.04), (0.100, 1.06, 0.16, 0.75, 0.16)),
    "long": ((0.090, 0.56, 0.02, 0.55, 0.00), (0.120, 0.76, 0.18, 0.80, 0.12)),
    "pointed": ((0.075, 0.62, 0.20, 0.75, 0.00), (0.115, 0.86, 0.38, 1.00, 0.05)),
}


def build(rng: np.random.Generator) -> Mesh:
    """A pepper; instances differ in habit, lobes, furrows, bend, bumps, stem and colours; half of them lie."""
    kind = rng.choice(3, p=(0.5, 0.25, 0.25))
    length, aspect, taper, square, sinking = rng.uniform(*HABITS[("blocky", "long", "pointed")[kind]])
    unit = _surface(rng, taper, square, sinking)
    unit[..., :2] *= aspect / np.ptp(unit[..., :2], axis=(0, 1)).max()
    unit[..., 2] /= np.ptp(unit[..., 2])
    unit[..., 0] *= rng.uniform(0.88, 1.0)
    unit[..., 0] += rng.uniform(-0.1, 0.1) * unit[..., 2] + rng.uniform(0, 0.25) * unit[..., 2] ** 2
    body = loft(length * unit)
    green = STEMS[rng.integers(len(STEMS))]
    skin = Mesh(body.vertices, body.triangles, _skin(rng, body.vertices))
    pepper = merge([skin, _stem(rng, length * unit[-1, 0]).painted(green)]).turned("z", rng.uniform(0, 360))
    if rng.random() < (0.42, 0.5, 0.7)[kind]:
        return settled(pepper, rng.uniform(80, 105), reach_deg=30)
    return settled(pepper, 0, reach_deg=12)


def _surface(rng: np.random.Generator, taper: float, square: float, sinking: float) -> np.ndarray:
    """The rings (LEVELS, SEGMENTS, 3) of a pepper of about unit radius and half length, from its tip up to the stem."""
    down = np.linspace(0, np.pi, LEVELS)[:, None]
    around = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    sine, cosine = np.sin(down), -np.cos(down)
    sine[[0, -1]] = 0
    count = 3 if rng.random() < 0.4 else 4
    warps = rng.uniform(0, 0.16, 2) * np.sin(np.outer(around, (1, 2)) + rng.uniform(0, 2 * np.pi, 2))
    furrow = (1 - np.abs(np.sin(count / 2 * (around + warps.sum(axis=1))))) ** rng.uniform(1.2, 2.6)
    unequal = 1 + (rng.uniform(0, 0.07, 2) * np.sin(np.outer(around, (1, 2)) + rng.uniform(0, 2 * np.pi, 2))).sum(
        axis=1
    )
    tip, belly, top = rng.uniform((0.10, 0.04, 0.12), (0.30, 0.16, 0.32))
    depth = belly + (tip - belly) * np.clip(-cosine, 0, 1) ** 2 + (top - belly) * np.clip(cosine, 0, 1) ** 2
    directions = np.stack([sine * np.cos(around), sine * np.sin(around), cosine + 0 * around], axis=-1)
    radius = sine**square * (1 - depth * furrow) * (unequal + bumps(rng, directions, rng.uniform(0.008, 0.03)))
    height = np.sign(cosine) * np.abs(cosine) ** square
    radius *= 1 + taper * height
    lobe = (1 - furrow) * unequal**3 * sine
    at_tip, at_top = np.exp(-(((down - 0.6) / 0.45) ** 2)), np.exp(-(((np.pi - down - 0.6) / 0.4) ** 2))
    height = height + lobe * (rng.uniform(0.03, 0.14) * at_top - rng.uniform(0.5, 1.2) * sinking * at_tip)
    height -= rng.uniform(0.14, 0.32) * np.exp(-(((np.pi - down) / rng.uniform(0.35, 0.6)) ** 2))
    height += 2 * sinking * np.exp(-((down / rng.uniform(0.4, 0.6)) ** 2))
    return np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=-1)


def _skin(rng: np.random.Generator, points: np.ndarray) -> np.ndarray:
    """The colours (V, 3) of points (V, 3) of a pepper: one colour, sometimes turning from green."""
    ripe = np.array((RED, YELLOW, ORANGE, GREEN, LIME)[rng.choice(5, p=(0.3, 0.2, 0.15, 0.25, 0.1))])
    green = np.clip(points @ rng.normal(0, 25, 3) + rng.uniform(-2.5, 0.2), 0, 0.9)[:, None]
    return (ripe + green * (GREEN - ripe)).astype(np.uint8)


def _stem(rng: np.random.Generator, foot: np.ndarray) -> Mesh:
    """A stem out of the sunken top at `foot` (3,): a flat star of a calyx, thick, curved, cut off at its wider end."""
    length, radius, lean, curve = rng.uniform((0.014, 0.0045, -0.2, 0.0), (0.036, 0.0075, 0.5, 1.3))
    along = np.concatenate([[-0.12, 0.0, 0.06, 0.14], np.linspace(0.25, 1, 10)])
    angles = lean + curve * along
    steps = np.diff(along, prepend=along[0])[:, None] * np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)])
    path = foot + length * (np.cumsum(steps, axis=0) - (0, 0, 0.12))
    flare = 1 + rng.uniform(0.8, 1.8) * np.exp(-(((along + 0.12) / 0.16) ** 2)) + rng.uniform(0.05, 0.4) * along**3
    ribbed = circle(radius, 20) * (1 + 0.10 * np.cos(5 * 2 * np.pi * np.arange(20) / 20))[:, None]
    return sweep(ribbed, path, up=(0, 1, 0), scales=flare[:, None])
