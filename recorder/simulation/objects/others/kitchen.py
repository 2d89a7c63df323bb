"""What else stands and lies in a kitchen: no bowls, no mugs."""

from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.handle import LOOP, D, handle
from orbitscan.recorder.simulation.objects.others.bodies import tongue
from orbitscan.recorder.simulation.objects.others.palette import BLACK, GREY, STEEL, WHITE, WOOD, Color, colors
from orbitscan.recorder.simulation.objects.solids import circle, cylinder, revolve, rounded_rectangle, sweep
from orbitscan.recorder.simulation.objects.vessel import hollow, lathe, silhouette, superellipse


def plate(rng: np.random.Generator) -> Mesh:
    """A plate with a rim or without, round or square with rounded corners, from a saucer to a dinner plate."""
    radius, share, thick = rng.uniform((0.075, 0.55, 0.003), (0.145, 0.75, 0.006))
    rise = radius * rng.uniform(0.10, 0.20)
    well = share * radius
    s = np.linspace(0, 1, 12)
    rimmed = np.interp(s, [0, 0.25, 1], [0, 0.65, 1])
    lower = rimmed if rng.random() < 0.5 else s ** rng.uniform(1.4, 2.2)
    wall = np.column_stack([well + (radius - well) * s, thick + rise * lower])
    foot = [(0, 0.002), (0.9 * well, 0.002), (0.92 * well, 0), (0.98 * well, 0)]
    inside = [(well, 2 * thick), (0.6 * well, 1.6 * thick), (0, 1.5 * thick)]
    profile = np.array([*foot, *wall, *(wall[::-1] + np.array([-0.001, 0.8 * thick])), *inside])
    outline = superellipse(rng.uniform(3, 5), segments=72) if rng.random() < 0.25 else circle(1, 72)
    dish = lathe(profile, outline)
    color, trim = colors(rng, 2)
    edge = np.hypot(*dish.vertices[:, :2].T)[:, None] > 0.93 * radius
    return replace(
        dish, colors=np.where(edge, trim, WHITE if rng.random() < 0.6 and trim != WHITE else color).astype(np.uint8)
    )


def pitcher(rng: np.random.Generator) -> Mesh:
    """A jug with a lip opposite its handle: straight, conical, bellied or drawn in."""
    height = rng.uniform(0.15, 0.26)
    radius = height * rng.uniform(0.26, 0.38)
    shares = ((1, 1, 1), (1, 0.92, 0.80), (0.75, 1, 0.80, 0.66, 0.78), (0.72, 1, 0.95, 0.85), (0.78, 0.9, 1))
    wall = silhouette(height, tuple(radius * share for share in shares[rng.integers(len(shares))]), 0.005)
    color, trim = colors(rng, 2)
    body = hollow(
        wall, rng.uniform(0.003, 0.005), 0.008, (color, WHITE if rng.random() < 0.5 else color), circle(1, 56)
    )
    x, y, z = body.vertices.T
    high, sharp = rng.uniform((0.12, 0.35), (0.30, 0.60))
    pull = np.clip(1 - (height - z) / (high * height), 0, 1) ** 2 * np.exp(-((np.arctan2(x, -y) / sharp) ** 2))
    lip = pull * rng.uniform(0.20, 0.42) * radius * np.clip(np.hypot(x, y) / radius, 0, 1)
    body = replace(body, vertices=body.vertices + np.column_stack([0 * x, -lip, 0.25 * lip]))
    bow = (LOOP, D)[rng.integers(2)]
    return merge([body, handle(rng, bow, wall, 0.002, min(height / 0.12, 1.6)).painted(trim)])


def spoon(rng: np.random.Generator) -> Mesh:
    """A spoon on its back, from tea to wooden cooking spoon, its bowl towards +x."""
    length, broad = rng.uniform((0.125, 0.17), (0.21, 0.23))
    wooden = rng.random() < 0.3
    length, broad = (1.35 * length, 0.85 * broad) if wooden else (length, broad)
    bowl, thick = broad * rng.uniform(1.3, 1.7) * length, 0.006 if wooden else 0.0018
    s = np.linspace(0, 1, 60)
    start = 1 - bowl / length
    t = np.clip((s - start) / (1 - start), 0, 1)
    egg = np.sqrt(np.clip(1 - (2 * t**0.9 - 1) ** 2, 0, 1))
    stem = length * np.interp(s, [0, 0.05, 0.2, start, 1], [0.030, 0.045, 0.030, 0.018, 0.018]) * (1.1 if wooden else 1)
    half = np.where(s < start, stem, np.maximum(egg * broad * length / 2, 0.003 + 0.012 * length * (1 - t)))
    dish = egg * half * rng.uniform(0.35, 0.6) * (t > 0)
    arch = 0 if wooden else rng.uniform(0.03, 0.06)
    middle = length * np.interp(
        s, [0, 0.5 * start, start, start + 0.45 * (1 - start), 1], [0, arch, 0.8 * arch + 0.02, 0, 0.01]
    )
    ladle = tongue(length * s, half, middle, dish, np.full(60, thick))
    return _two_toned(
        ladle, WOOD if wooden else STEEL, colors(rng, 1)[0] if rng.random() < 0.3 else GREY, 0.45 * length
    )


def fork(rng: np.random.Generator) -> Mesh:
    """A fork of three or four tines on its back, the tines towards +x."""
    length, broad, arch = rng.uniform((0.145, 0.11, 0.03), (0.21, 0.15, 0.06))
    count, wide = rng.integers(3, 5), broad * length
    s = np.linspace(0, 1, 40)
    half = length * np.interp(s, [0, 0.04, 0.2, 0.85, 1], [0.035, 0.05, 0.03, 0.016, 0.022])
    half[-8:] = np.maximum(half[-8:], np.linspace(0.3, 1, 8) ** 0.6 * wide / 2)
    curve = length * np.interp(s, [0, 0.45, 0.78, 1], [0, 0.9 * arch, arch, 0.010])
    parts = [tongue(0.72 * length * s, half, curve, 0 * s, np.full(40, 0.0020))]
    t = np.linspace(0, 1, 12)
    rise = curve[-1] * (1 - 1.6 * t) ** 2 + 0.001 + 0.020 * length / 0.2 * np.maximum(t - 0.6, 0)
    for y in np.linspace(-1, 1, count) * (wide / 2 - 0.0018):
        path = np.column_stack([length * (0.71 + 0.28 * t), np.full(12, y), rise])
        taper = np.interp(t, [0, 0.7, 1], [1, 0.9, 0.35])[:, None]
        parts.append(sweep(rounded_rectangle(0.0036, 0.0020, 0.0006, 3), path, scales=taper))
    whole = merge(part.painted(STEEL) for part in parts)
    return _two_toned(whole, STEEL, BLACK if rng.random() < 0.4 else GREY, 0.42 * length).turned(
        "z", rng.uniform(-15, 15)
    )


def wine_glass(rng: np.random.Generator) -> Mesh:
    """A glass on a stem: for red or white wine, a flute, a coupe, a cocktail glass."""
    height, foot, stem = rng.uniform((0.14, 0.029, 0.003), (0.225, 0.040, 0.005))
    bowls = (  # shares of the height where the bowl begins, its radius, its wall
        (rng.uniform(0.42, 0.52), rng.uniform(0.19, 0.24), (0.10, 0.72, 0.98, 1, 0.92, 0.82)),
        (rng.uniform(0.34, 0.46), rng.uniform(0.14, 0.16), (0.10, 0.60, 0.85, 0.95, 0.95, 0.88)),
        (rng.uniform(0.66, 0.76), rng.uniform(0.26, 0.32), (0.08, 0.55, 0.80, 0.92, 0.98, 1)),
        (rng.uniform(0.58, 0.68), rng.uniform(0.26, 0.32), (0.06, 0.25, 0.44, 0.63, 0.82, 1)),
    )
    begin, radius, shares = bowls[rng.integers(len(bowls))]
    depth = (1 - begin) * height
    shell = silhouette(depth, tuple(radius * height * share for share in shares), 0.001, 14)[3:]
    shell[:, 1] += begin * height
    inner = shell[::-1] - (0.0016, 0)
    inner = inner[inner[:, 0] > 0.003]
    base = [(0, 0), (foot, 0), (foot, 0.002), (0.4 * foot, 0.006), (stem, 0.016), (stem, 0.5 * begin * height)]
    join = [(stem, 0.94 * begin * height)]
    glass = revolve(np.array([*base, *join, *shell, *inner, (0, inner[-1, 1] + 0.001)]), 48)
    wine = glass.vertices[:, 2] > (begin + rng.uniform(0.1, 0.5) * (1 - begin)) * height
    color = colors(rng, 1)[0]
    return replace(glass, colors=np.where(wine[:, None], (214, 222, 226), color).astype(np.uint8))


def frying_pan(rng: np.random.Generator) -> Mesh:
    """A pan or a saucepan with a long handle towards +y, some with a lid."""
    radius, share = rng.uniform((0.075, 0.25), (0.13, 0.40))
    height = share * radius if rng.random() < 0.6 else rng.uniform(0.7, 1.1) * min(radius, 0.10)
    flare = rng.uniform(0.78, 0.98)
    outside, inside = ((BLACK, GREY), (STEEL, GREY), (colors(rng, 1)[0], BLACK))[rng.integers(3)]
    wall = silhouette(height, (flare * radius, (1 + flare) / 2 * radius, radius), 0.005, 8)
    parts = [hollow(wall, 0.003, 0.006, (outside, inside), circle(1, 64))]
    s = np.linspace(0, 1, 24)
    long, up = rng.uniform((0.12, 0.0), (0.19, 0.30))
    path = np.column_stack([0 * s, radius - 0.004 + long * s, 0.82 * height + up * long * s * (1 - 0.4 * s)])
    swell = np.interp(s, [0, 0.25, 0.6, 0.95, 1], [0.8, 0.75, 1.1, 1, 0.7])[:, None]
    grip = sweep(rounded_rectangle(0.022, 0.013, 0.005, 4), path, scales=swell)
    parts.append(grip.painted((BLACK, WOOD, STEEL)[rng.integers(3)]))
    if rng.random() < 0.25:
        lid = [(0, 0), (radius, 0), (radius, 0.003), (0.5 * radius, 0.16 * radius), (0, 0.2 * radius)]
        parts.append(revolve(np.array(lid), 48).moved(z=height).painted(STEEL))
        parts.append(cylinder(0.014, 0.022, 0.004).moved(z=height + 0.18 * radius).painted(BLACK))
    return merge(parts)


def _two_toned(mesh: Mesh, metal: Color, grip: Color, end: float) -> Mesh:
    """The mesh with a grip of another colour up to x = end."""
    return replace(mesh, colors=np.where(mesh.vertices[:, :1] < end, grip, metal).astype(np.uint8))
