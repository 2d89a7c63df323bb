"""Water bottles: surfaces of revolution 18 to 27 cm high, straight or with a waist to grip, open or capped."""

import numpy as np

from recorder.objects.mesh import Mesh, merge
from recorder.objects.solids import revolve

SEGMENTS = 96  # facets this fine are no features
STEEL, BLACK, WHITE = (188, 192, 196), (58, 60, 66), (234, 234, 230)
RED, BLUE, AQUA, GREEN = (188, 58, 52), (44, 88, 160), (104, 186, 204), (86, 148, 92)
ORANGE, PINK, NAVY = (226, 128, 52), (214, 128, 150), (52, 62, 96)
BODIES = (STEEL, BLACK, WHITE, RED, BLUE, AQUA, GREEN, ORANGE, PINK, NAVY)
CAPS = (BLACK, WHITE, STEEL, RED, BLUE, ORANGE)


def everyday(rng: np.random.Generator) -> Mesh:
    """A bottle; instances differ in proportions, waist, rings, shoulder, in the closure (or none) and in colours."""
    radius, height, neck = rng.uniform((0.031, 0.165, 0.34), (0.041, 0.225, 0.66))
    neck *= radius
    shoulder = rng.uniform(0.5, 1.3) * radius
    wall = _wall(rng, radius, height - shoulder)
    angles = np.linspace(0, np.pi / 2, 9)[1:]
    roundness = rng.uniform(0.75, 1.25)
    slope = np.column_stack(
        [
            neck + (radius - neck) * np.cos(angles) ** roundness,
            height - shoulder + shoulder * np.sin(angles) ** roundness,
        ]
    )
    foot = [(0, 0.004), (0.70 * radius, 0.003), (0.80 * radius, 0), (0.93 * radius, 0)]
    top = height + 0.014
    collar = [(neck, height + 0.003), (neck + 0.003, height + 0.004), (neck + 0.003, height + 0.007)]
    mouth = [*collar, (neck - 0.001, height + 0.008), (neck - 0.001, top)]
    bore = neck - 0.004
    hollow = [(bore, top), (bore, height), (0.6 * radius + 0.4 * bore, height - shoulder), (0, height - 1.3 * shoulder)]
    body = revolve(np.array([*foot, *wall, *slope, *mouth, *hollow]), SEGMENTS)
    color, base, lid = BODIES[rng.integers(len(BODIES))], BODIES[rng.integers(3)], CAPS[rng.integers(len(CAPS))]
    z = body.vertices[:, 2]
    dipped = rng.integers(2) * rng.uniform(0.1, 0.3) * height  # the part of the foot in another colour
    colors = np.where((z < dipped)[:, None], np.array(base), np.array(color))
    colors[z > height] = BLACK if color == STEEL else STEEL
    painted = Mesh(body.vertices, body.triangles, colors.astype(np.uint8))
    return merge([painted, *(part.moved(z=height + 0.0075).painted(lid) for part in _closure(rng, neck))])


def _wall(rng: np.random.Generator, radius: float, top: float) -> np.ndarray:
    """The wall (P, 2) from the foot to the shoulder, with or without a waist where the hand grips, grooves about it."""
    waist, middle, width = rng.uniform((0.06, 0.45, 0.10), (0.20, 0.65, 0.18)) * (rng.integers(2), 1, 1)
    count, gap, depth = int(rng.integers(4)), rng.uniform(0.010, 0.018), rng.uniform(0.0015, 0.0030)
    levels = np.linspace(0.006, top, 8)
    grooves = middle * top + gap * (np.arange(count) - (count - 1) / 2)
    offsets = np.array([-0.0032, -0.0016, 0.0016, 0.0032])
    cut = (grooves[:, None] + offsets).ravel()
    near = np.abs(levels[:, None] - grooves).min(axis=1, initial=1.0)
    z = np.concatenate([levels[near > 0.005], cut])
    sunk = np.concatenate([np.zeros((near > 0.005).sum()), np.tile([0, depth, depth, 0], count)])
    order = np.argsort(z)
    z, sunk = z[order], sunk[order]
    radii = radius * (1 - waist * np.exp(-(((z / top - middle) / width) ** 2))) - sunk
    return np.column_stack([radii, z])


def _closure(rng: np.random.Generator, neck: float) -> list[Mesh]:
    """A screw cap, a sports cap with its spout, or nothing: an open bottle."""
    kind = rng.integers(3)
    if kind == 2:
        return []
    r, h = neck + 0.004, rng.uniform(0.014, 0.026)
    profile = [(0, 0), (r - 0.001, 0), (r, 0.001), (r, 0.7 * h), (0.94 * r, 0.93 * h), (0.85 * r, h)]
    if kind == 1:
        s = min(0.010, 0.5 * neck)
        spout = [(s, h + 0.003), (s, h + 0.012), (s + 0.002, h + 0.013), (s + 0.002, h + 0.018), (s, h + 0.021)]
        profile += [*spout, (0, h + 0.021)]
    else:
        profile += [(0, h)]
    return [revolve(np.array(profile), SEGMENTS)]


ROUND = (everyday,)  # surfaces of revolution
STYLES = ROUND
