"""What food and paper come in: cans, boxes, cartons, bags."""

from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.closure import screw_cap
from orbitscan.recorder.simulation.objects.others.bodies import along_x, carton, lying, rectangle, rumpled
from orbitscan.recorder.simulation.objects.others.palette import STEEL, WHITE, colors
from orbitscan.recorder.simulation.objects.solids import box, circle, cylinder, ellipsoid, loft, prism, revolve

DRINKS = ((0.033, 0.115), (0.033, 0.122), (0.0265, 0.134), (0.029, 0.146), (0.033, 0.168))  # radius and height [m]
TINS = ((0.0425, 0.037), (0.033, 0.085), (0.037, 0.108), (0.0425, 0.117), (0.050, 0.122))


def soda_can(rng: np.random.Generator) -> Mesh:
    """A can of 25 to 50 cl, shut or opened, some dented, some lying."""
    radius, height = np.array(DRINKS[rng.integers(len(DRINKS))]) * rng.uniform(0.98, 1.02, 2)
    neck = radius * rng.uniform(0.78, 0.84)
    color, trim = colors(rng, 2)
    body = [
        (radius, 0.09 * height),
        *((radius, z * height) for z in np.linspace(0.2, 0.8, 12)),
        (radius, 0.88 * height),
    ]
    foot = [(0, 0.008), (0.55 * radius, 0.005), (0.72 * radius, 0), (0.80 * radius, 0.001)]
    lid = [(neck, 0.97 * height), (neck + 0.001, height), (neck - 0.001, height), (neck - 0.003, height - 0.004)]
    can = _dented(rng, revolve(np.array([*foot, *body, *lid, (0, height - 0.004)]), 48), radius, height)
    band = np.abs(can.vertices[:, 2] / height - 0.5)[:, None]
    skin = np.where(band > 0.38, STEEL, np.where(band > 0.22, color, trim))
    tab = ellipsoid(0.011, 0.007, 0.0018, 12).moved(0.002, 0, height - 0.002).painted(STEEL)
    if rng.random() < 0.3:  # opened: the tab stands up
        tab = tab.moved(z=-height).turned("y", -50).moved(z=height + 0.004)
    whole = merge([replace(can, colors=skin.astype(np.uint8)), tab]).turned("z", rng.uniform(0, 360))
    return lying(whole) if rng.random() < 0.2 else whole


def food_can(rng: np.random.Generator) -> Mesh:
    """A tin with a rim at both ends, smooth or beaded, some without a label, some opened, its lid bent up."""
    radius, height = np.array(TINS[rng.integers(len(TINS))]) * rng.uniform(0.95, 1.05, 2)
    z = np.linspace(0.004, height - 0.004, 40)
    beaded = (z > 0.3 * height) & (z < 0.7 * height) & (rng.random() < 0.6)
    wall = np.column_stack([radius - 0.001 - 0.0012 * beaded * (1 + np.sin(z / 0.0012)), z])
    rims = [(radius, 0), (radius, 0.003)], [(radius, height - 0.003), (radius, height)]
    opened = rng.random() < 0.3
    floor = 0.006 if opened else height - 0.003
    inside = [(radius - 0.002, height), (radius - 0.002, floor), (0, floor)]
    color = (178, 172, 164) if rng.random() < 0.3 else colors(rng, 1)[0]
    tin = revolve(np.array([(0, 0.002), (radius - 0.003, 0.002), *rims[0], *wall, *rims[1], *inside]), 48)
    skin = np.where(np.abs(tin.vertices[:, 2:] / height - 0.5) > 0.42, STEEL, color).astype(np.uint8)
    parts = [replace(tin, colors=skin)]
    if opened:
        lid = cylinder(radius - 0.003, 0.001, segments=40).moved(radius).turned("y", -rng.uniform(40, 100))
        parts.append(lid.moved(-radius + 0.002, 0, height - 0.001).painted(STEEL))
    return merge(parts).turned("z", rng.uniform(0, 360))


def cereal_box(rng: np.random.Generator) -> Mesh:
    """A carton of cereals, crackers or tea, standing or lying, some with the flaps open."""
    depth, width, height = rng.uniform((0.045, 0.12, 0.16), (0.085, 0.22, 0.31))
    if rng.random() < 0.3:
        depth, width, height = rng.uniform((0.06, 0.08, 0.08), (0.09, 0.15, 0.14))
    color, trim, third = colors(rng, 3)
    bulge = rng.uniform(0, 0.003)
    body = carton(depth, width, height, bulge)
    picture = rng.uniform(0.35, 0.7, 2) * (width, height)
    panels = box(depth + 2 * bulge + 0.0010, picture[0], picture[1]).moved(z=rng.uniform(0.05, 0.25) * height)
    parts = [body.painted(color), panels.painted(trim)]
    if rng.random() < 0.4:
        for side in (-1, 1):
            flap = box(0.9 * depth, 0.98 * width, 0.001).moved(0.45 * depth).turned("y", -rng.uniform(20, 140))
            parts.append(flap.turned("z", 90 - 90 * side).moved(-side * 0.49 * depth, 0, height - 0.001).painted(third))
    whole = merge(parts)
    return lying(whole) if rng.random() < 0.3 else whole.turned("z", rng.uniform(-8, 8))


def milk_carton(rng: np.random.Generator) -> Mesh:
    """A carton with a gable, a slanted top or a flat one, with a screw cap or none."""
    length, width, height = rng.uniform((0.060, 0.060, 0.11), (0.098, 0.095, 0.22))
    style, rise = rng.integers(3), rng.uniform(0.45, 0.75) * width
    color, trim = colors(rng, 2)
    outline = rectangle(length, width)
    folds = [(1, 1, 0), (1, 1, 0.5), (1, 1, 1)]
    rings = [np.column_stack([outline * (a, b), np.full(len(outline), z * height)]) for a, b, z in folds]
    if style == 0:
        ridge = outline * (1, 0.05)
        rings += [np.column_stack([ridge, np.full(len(ridge), height + rise + d)]) for d in (0, 0.014)]
    elif style == 1:
        rings[-1][:, 2] += rise * outline[:, 0] / length
    parts = [loft(np.stack(rings)).painted(color)]
    parts.append(prism(outline * 1.008, 0.35 * height).moved(z=0.2 * height).painted(trim))
    if rng.random() < 0.65:
        cap = screw_cap(rng.uniform(0.011, 0.016), rng.uniform(0.010, 0.018))
        slope = (np.degrees(np.arctan2(rise, width / 2)), np.degrees(np.arctan2(rise, length)), 0)[style]
        cap = cap.turned("x" if style == 0 else "y", -slope).moved(z=height - 0.003)
        cap = cap.moved(y=0.26 * width, z=0.48 * rise) if style == 0 else cap.moved(x=-0.12 * length * (style == 1))
        parts.append((cap.moved(z=-0.06 * length) if style == 1 else cap).painted(WHITE))
    return merge(parts).turned("z", rng.uniform(-8, 8))


def food_bag(rng: np.random.Generator) -> Mesh:
    """A bag: a pillow of crisps that lies, or one of coffee or rice that stands, folded over at its top."""
    color, trim = colors(rng, 2)
    s = np.linspace(0, 1, 44)
    outline = circle(1, 40)
    outline = np.sign(outline) * np.abs(outline) ** 0.8
    if rng.random() < 0.55:
        length, half, thick = rng.uniform((0.15, 0.055, 0.02), (0.27, 0.095, 0.036))
        full = np.interp(s, [0, 0.05, 0.95, 1], [0, 0, 1, 1]) * np.sin(np.pi * np.clip((s - 0.05) / 0.9, 0, 1)) ** 0.6
        thickness = 0.001 + thick * full * np.interp(s, [0, 0.95, 1], [1, 1, 0])
        wide = half * (1 - 0.12 * full)
        bag = along_x(length * s, outline * np.stack([wide, thickness], axis=1)[:, None])
    else:
        length, half, thick = rng.uniform((0.16, 0.040, 0.025), (0.26, 0.065, 0.042))
        full = np.interp(s, [0, 0.55, 0.88, 1], [1, 1.05, 0.08, 0.03])
        bag = along_x(-length * s, outline * np.stack([half * (1.08 - 0.08 * full), thick * full], axis=1)[:, None])
        bag = bag.turned("z", 90).turned("x", -90)
        bag = bag if bag.bounds[1][2] > 0.5 * length else bag.turned("x", 180)
    bag = rumpled(rng, bag, rng.uniform(0.002, 0.005), 2.5)
    place = np.append(np.repeat(s, 40), [0, 1])[:, None]
    return replace(bag, colors=np.where(np.abs(place - 0.5) < 0.2, trim, color).astype(np.uint8))


def tissue_box(rng: np.random.Generator) -> Mesh:
    """A flat box or a cube, a tissue standing out of its slot, or none left."""
    length, width, height = rng.uniform((0.20, 0.105, 0.045), (0.25, 0.13, 0.10))
    if rng.random() < 0.4:
        length, width, height = rng.uniform((0.105, 0.105, 0.11), (0.12, 0.12, 0.14))
    color, trim = colors(rng, 2)
    body = carton(width, length, height, rng.uniform(0, 0.003)).painted(color)
    slot = prism(circle(1, 32) * (0.22 * width, 0.32 * length), 0.001).moved(z=height).painted(trim)
    parts = [body, slot]
    if rng.random() < 0.8:
        s = np.linspace(0, 1, 16)
        wave, rise, lean = rng.uniform((1, 0.04, -0.4), (3, 0.085, 0.4))
        y = 0.9 * circle(1, 36)
        rings = []
        for share in s:
            spread = np.interp(share, [0, 0.4, 1], [0.010, 0.014, 0.004])
            ring = y * (spread, 0.28 * length * np.interp(share, [0, 0.6, 1], [0.5, 0.6, 0.12]))
            ring[:, 0] += 0.016 * share * np.sin(wave * np.pi * ring[:, 1] / (0.2 * length)) + lean * rise * share
            rings.append(np.column_stack([ring, np.full(36, height - 0.002 + rise * share)]))
        parts.append(rumpled(rng, loft(np.stack(rings)), 0.003, 2.5).painted(WHITE))
    return merge(parts).turned("z", rng.uniform(-8, 8))


def _dented(rng: np.random.Generator, can: Mesh, radius: float, height: float) -> Mesh:
    """The can, two in five with a dent in its side."""
    if rng.random() > 0.4:
        return can
    x, y, z = can.vertices.T
    place = np.array([radius, 0, rng.uniform(0.35, 0.65) * height])
    depth = rng.uniform(0.004, 0.014) * np.exp(-((np.stack([x, y, z], axis=1) - place) ** 2).sum(axis=1) / 0.016**2)
    return replace(can, vertices=can.vertices - depth[:, None] * (1, 0, 0))
