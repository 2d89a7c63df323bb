"""Fruit and bread, none of them apples or peppers."""

from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.fruit import bumps, settled
from orbitscan.recorder.simulation.objects.others.bodies import along_x, domed, rumpled
from orbitscan.recorder.simulation.objects.others.palette import BLACK, CREAM, CRUST, GREEN, ORANGE, WHITE, WOOD, YELLOW
from orbitscan.recorder.simulation.objects.solids import circle, revolve, sweep


def banana(rng: np.random.Generator) -> Mesh:
    """A banana on its side, or a hand of three to five that stands like an arch."""
    if rng.random() < 0.6:
        return _finger(rng, rng.uniform(0.15, 0.22)).turned("x", rng.uniform(-12, 12))
    length, count = rng.uniform(0.15, 0.20), rng.integers(3, 6)
    turns = np.linspace(-1, 1, count) * rng.uniform(5, 7) * count
    arches = [_finger(rng, length * rng.uniform(0.92, 1)).turned("x", 90) for _ in range(count)]
    return merge([arch.moved(0.42 * length).turned("z", turn) for arch, turn in zip(arches, turns, strict=True)])


def _finger(rng: np.random.Generator, length: float) -> Mesh:
    """A banana along an arc in the plane z = 0 that opens towards -y, its stem at the lower x."""
    s = np.linspace(0, 1, 40)
    bend, radius = rng.uniform((0.45, 0.0155), (0.85, 0.0200))
    angles = bend * (2 * s - 1)
    path = length / (2 * bend) * np.column_stack([np.sin(angles), np.cos(angles) - 1, 0 * s])
    taper = np.interp(s, [0, 0.10, 0.16, 0.30, 0.55, 0.80, 0.95, 1], [0.30, 0.32, 0.55, 0.90, 1, 0.88, 0.40, 0.20])
    outline = radius * circle(1, 20) * (1 + 0.05 * np.cos(5 * 2 * np.pi * np.arange(20) / 20))[:, None]
    finger = sweep(outline, path, scales=taper[:, None])
    place = np.append(np.repeat(s, 20), [0, 1])[:, None]
    skin = np.where((place < 0.05) | (place > 0.97), BLACK, np.where(place < 0.14, GREEN, YELLOW))
    return replace(finger, colors=skin.astype(np.uint8))


def pear(rng: np.random.Generator) -> Mesh:
    """A pear, from stout to long-necked, standing or lying."""
    radius, slender, neck, shoulder = rng.uniform((0.030, 1.25, 0.30, 0.30), (0.040, 1.75, 0.55, 0.42))
    turns = np.linspace(0, np.pi, 27)
    z = (1 - np.cos(turns)) / 2
    waist = 1 - (1 - neck) / (1 + np.exp(-(z - shoulder - 0.22) / 0.07))
    height = 2 * radius * slender
    profile = np.column_stack([radius * 1.05 * np.sin(turns) ** 0.85 * waist, height * z])
    profile[[0, -1], 0] = 0
    body = revolve(profile, 36)
    swell = 1 + bumps(rng, (body.vertices - (0, 0, height / 2)) / height * 2, 0.02)
    body = replace(body, vertices=body.vertices * np.column_stack([swell, swell, np.ones_like(swell)]))
    s = np.linspace(0, 1, 8)[:, None]
    stem = s * (*rng.uniform(-0.008, 0.008, 2), rng.uniform(0.012, 0.024)) + (0, 0, height - 0.003)
    skin = (GREEN, YELLOW, ORANGE)[rng.integers(3)]
    fruit = merge([body.painted(skin), sweep(circle(0.0017, 8), stem, up=(1, 0, 0)).painted(WOOD)])
    return settled(fruit, 0, 25) if rng.random() < 0.5 else settled(fruit, 85, 40)


def bread_loaf(rng: np.random.Generator) -> Mesh:
    """A loaf: from a tin, free and round, long, or half of one, cut; its top slashed or not."""
    length, half, height = rng.uniform((0.19, 0.045, 0.075), (0.30, 0.060, 0.115))
    tin, cut = rng.random() < 0.45, rng.random() < 0.4
    s = np.linspace(-1, 1, 48)
    ends = (1 - np.abs(s) ** (9 if tin else rng.uniform(2.2, 3.2))) ** 0.5
    ends = np.maximum(ends, 0.75 if tin else 0.06)
    if cut:
        length, ends = 0.6 * length, np.where(s > 0.2, ends[np.abs(s - 0.2).argmin()], ends)
    depth, count = rng.choice([0, 0.05, 0.08]), rng.integers(2, 6)
    slashes = 1 - depth * np.maximum(0, np.cos(np.pi * count * (s + 1))) ** 6
    outline = domed(half, height, rng.uniform(3.2, 5) if tin else rng.uniform(2, 2.5))
    sections = outline * np.stack([ends, ends**0.8 * slashes], axis=1)[:, None]
    if tin:  # the crust swells over the tin's edge
        over = 1 + rng.uniform(0.02, 0.12) * np.exp(-((outline[:, 1] / height - 0.72) ** 2) / 0.02)
        sections[..., 0] *= over
    loaf = rumpled(rng, along_x(length / 2 * s, sections), 0.003, 1.0)
    skin = np.where(loaf.vertices[:, 2:] < 0.15 * height, WOOD, CRUST)
    if cut:
        skin[-1] = CREAM
    return replace(loaf, colors=skin.astype(np.uint8)).turned("z", rng.uniform(-10, 10))


def mushroom(rng: np.random.Generator) -> Mesh:
    """A mushroom with a cap from round to open, standing on its stem, lying or upside down."""
    radius, dome, stem, length = rng.uniform((0.022, 0.50, 0.30, 0.5), (0.045, 0.90, 0.48, 1.2))
    turns = np.linspace(0, np.pi / 2, 13)
    high, gills = radius * length, radius * rng.uniform(0.05, 0.18)
    under = [(1.15 * stem, high + 0.4 * gills), (0.75, high + 0.6 * gills), (0.93, high - 0.3 * gills)]
    foot = [(0, 0), (0.85 * stem, 0), (1.1 * stem, 0.12 * high), (stem, 0.5 * high)]
    cap = np.column_stack([np.cos(turns), high + radius * dome * np.sin(turns) ** 0.9])
    cap[-1, 0] = 0
    profile = np.concatenate([foot, under, cap]) * (radius, 1)
    whole = rumpled(rng, revolve(profile, 40), 0.03 * radius, 1.0)
    skin = np.where(np.hypot(*whole.vertices[:, :2].T)[:, None] < 1.2 * stem * radius, WHITE, CREAM)
    tilt, reach = ((0, 8), (100, 40), (180, 30))[rng.integers(3)]
    return settled(replace(whole, colors=skin.astype(np.uint8)), tilt, reach)
