"""Tools out of the drawer, lying; none of them pliers."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.fruit import settled
from orbitscan.recorder.simulation.objects.others.bodies import hoop, lying
from orbitscan.recorder.simulation.objects.others.palette import BRASS, STEEL, WHITE, WOOD, YELLOW, colors
from orbitscan.recorder.simulation.objects.solids import (
    box,
    circle,
    cylinder,
    ellipsoid,
    prism,
    revolve,
    rounded_rectangle,
    sweep,
)
from orbitscan.recorder.simulation.objects.vessel import fluted, lathe


def scissors(rng: np.random.Generator) -> Mesh:
    """Scissors from nail to tailor's, shut or opened up to 60 degrees; the bows round, oval, alike or not."""
    blade, share = rng.uniform((0.055, 0.7), (0.130, 1.3))
    arm, opening = blade * share * 0.55, rng.choice([0, 1]) * rng.uniform(8, 60)
    color = colors(rng, 1)[0]
    root, tip = 0.085 * blade + 0.003, 0.0008
    long = rng.uniform(1, 1.5)
    outline = np.array([(-0.12, -root), (0.3, -root), (1, -tip), (1, tip), (0.3, 0.55 * root), (-0.12, root)])
    outline[:, 0] *= np.where(np.abs(outline[:, 0]) > 0, blade, 1)
    halves = []
    for side, size in ((1, 1.0), (-1, long)):
        rx, ry = 0.018 * size + 0.008 * size * rng.random(), 0.015
        thick = rng.uniform(0.008, 0.012)
        bow = hoop(rounded_rectangle(0.008, thick, 0.003, 3), rx, ry, 36).turned("z", -8)
        place = np.array([-arm - rx, -ry - 0.005, 0])
        s = np.linspace(0, 1, 10)[:, None]
        path = s * np.array([-arm, -0.7 * ry - 0.005, 0]) + (1 - s) * np.array([-0.05 * blade, 0, 0])
        parts = [
            prism(outline, 0.0022).moved(z=0.0001).painted(STEEL),
            sweep(rounded_rectangle(0.011, thick, 0.003, 3), path).painted(color),
            bow.moved(*place).painted(color),
        ]
        half = merge(parts)
        half = half if side == 1 else half.turned("x", 180)
        halves.append(half.turned("z", side * opening / 2))
    return merge([*halves, cylinder(0.004, 0.007, 0.001, 20).moved(z=-0.0035).painted(BRASS)])


def hammer(rng: np.random.Generator) -> Mesh:
    """A claw, an engineer's or a ball-peen hammer, or a mallet; its handle to -x."""
    style, length, scale = rng.integers(4), rng.uniform(0.24, 0.36), rng.uniform(0.85, 1.2)
    s = np.linspace(0, 1, 24)
    swell = np.interp(s, [0, 0.12, 0.5, 0.85, 1], [0.8, 0.72, 0.8, 1.15, 1.0])[:, None]
    shaft = sweep(circle(1, 20) * (0.0155 * scale, 0.0115 * scale), np.outer(-s, (length, 0, 0)), scales=swell)
    wooden = rng.random() < 0.5
    parts = [shaft.painted(WOOD if wooden else colors(rng, 1)[0])]
    head, metal = 0.012 * scale, (STEEL, (110, 112, 118), (84, 80, 80))[rng.integers(3)]
    if style == 3:  # a mallet
        radius, half = rng.uniform((0.024, 0.045), (0.038, 0.070))
        parts.append(cylinder(radius, 2 * half, 0.004, 40).moved(z=-half).turned("x", 90).painted(metal))
        return merge(parts)
    s = np.linspace(0, 1, 14)
    face = sweep(circle(head, 28), np.outer(s, (0, 0.055 * scale, 0)), up=(0, 0, 1),
                 scales=np.interp(s, [0, 0.5, 0.65, 0.95, 1], [1.05, 0.85, 1.1, 1.1, 1.0])[:, None])  # fmt: skip
    parts += [
        face.painted(metal),
        box(0.026 * scale, 0.030 * scale, 0.025 * scale, 0.003).moved(z=-head).painted(metal),
    ]
    if style == 0:  # two claws that bend towards the handle
        bend = np.column_stack([-0.035 * scale * s**2, -0.075 * scale * s])
        thin = np.column_stack([np.interp(s, [0, 1], [1.6, 0.8]), np.interp(s, [0, 1], [1, 0.5])])
        for side in (-1, 1):
            path = np.column_stack([bend, side * (0.004 + 0.006 * s) * scale])
            parts.append(sweep(rounded_rectangle(0.010, 0.010, 0.003, 3), path, scales=thin).painted(metal))
    elif style == 1:
        parts.append(ellipsoid(0.8 * head, 0.03 * scale, 0.8 * head).moved(y=-0.022 * scale).painted(metal))
    else:
        wedge = np.column_stack([np.interp(s, [0, 1], [1, 1.0]), np.interp(s, [0, 1], [1, 0.15])])
        path = np.outer(s, (0, -0.06 * scale, 0))
        parts.append(
            sweep(rounded_rectangle(2 * head, 2 * head, 0.002, 3), path, up=(1, 0, 0), scales=wedge).painted(metal)
        )
    return merge(parts)


def screwdriver(rng: np.random.Generator) -> Mesh:
    """A screwdriver from stubby to long, its handle fluted or three-sided."""
    grip, radius, shank, rod = rng.uniform((0.06, 0.011, 0.03, 0.0022), (0.115, 0.018, 0.17, 0.0042))
    color, trim = colors(rng, 2)
    shape = np.array(
        [(0, 0), (0.7, 0), (0.95, 0.05), (1, 0.25), (0.92, 0.55), (0.62, 0.78), (0.72, 0.86), (0.68, 1), (0, 1)]
    )
    s = np.linspace(0, 1, 40)
    steps = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(shape, axis=0), axis=1))])
    profile = np.column_stack([np.interp(s, steps / steps[-1], shape[:, i]) for i in (0, 1)]) * (radius, grip)
    handle = lathe(profile, fluted(int(rng.choice([3, 6, 8])), rng.uniform(0.08, 0.2), 48))
    parts = [handle.painted(color), cylinder(0.72 * radius, 0.06 * grip, 0.001).moved(z=0.9 * grip).painted(trim)]
    parts.append(cylinder(rod, shank, 0, 16).moved(z=grip - 0.001).painted(STEEL))
    parts.append(prism(circle(1, 12) * (0.8 * rod, 2 * rod), 0.008).moved(z=grip + shank - 0.004).painted(STEEL))
    return lying(merge(parts))


def flashlight(rng: np.random.Generator) -> Mesh:
    """A torch with a head wider than its body, or a lantern with a handle; lying, or standing on its lens."""
    radius, length, flare, head = rng.uniform((0.010, 0.10, 1.25, 0.15), (0.020, 0.26, 2.1, 0.30))
    length = max(length, 5.5 * radius)
    color, trim = colors(rng, 2)
    wide, neck = flare * radius, (1 - head) * length
    tail = [(0, 0), (0.8 * radius, 0), (radius, 0.01), (radius, 0.5 * neck), (radius, neck)]
    bell = [(wide, neck + 0.35 * head * length), (wide, length), (wide - 0.002, length), (0.85 * wide, length - 0.003)]
    body = revolve(np.array([*tail, *bell, (0.35 * wide, length - 0.5 * wide), (0, length - 0.55 * wide)]), 56)
    rings = [cylinder(1.06 * radius, 0.004, 0.001).moved(z=z * neck).painted(trim) for z in (0.15, 0.22, 0.7, 0.77)]
    button = box(0.007, 0.010, 0.022, 0.001).moved(radius, 0, 0.6 * neck).painted(trim)
    glass = cylinder(0.9 * wide, 0.0012).moved(z=length - 0.006).painted(WHITE if rng.random() < 0.5 else YELLOW)
    parts = [body.painted(color), *rings, button, glass]
    if rng.random() < 0.25:  # a lantern's handle
        t = np.linspace(-1, 1, 24)
        path = np.column_stack([-radius - 0.045 * (1 - t**6), 0 * t, 0.55 * length + 0.33 * length * t])
        parts.append(sweep(circle(0.008, 14), path, up=(0, 1, 0)).painted(trim))
    whole = merge(parts)
    return whole.turned("x", 180) if rng.random() < 0.25 else lying(whole.turned("z", rng.uniform(-60, 60)))


def light_bulb(rng: np.random.Generator) -> Mesh:
    """A bulb: pear-shaped, a globe, a candle or a reflector, lying on its side or standing on its glass."""
    style, radius, ratio = rng.integers(4), rng.uniform(0.026, 0.036), rng.uniform(0.92, 1.08)
    screw = 0.0135 if rng.random() < 0.7 else 0.007
    shapes = (
        [(0.46, 0.0), (0.50, 0.25), (0.72, 0.7), (0.96, 1.3), (1, 1.7), (0.9, 2.15), (0.6, 2.52), (0, 2.7)],
        [(0.45, 0.0), (0.60, 0.2), (1.1, 0.6), (1.36, 1.2), (1.4, 1.5), (1.3, 2.0), (0.9, 2.6), (0.4, 2.88), (0, 2.92)],
        [(0.30, 0.0), (0.34, 0.2), (0.55, 0.8), (0.58, 1.1), (0.48, 1.7), (0.28, 2.3), (0.12, 2.75), (0, 3)],
        [(0.48, 0.0), (0.52, 0.5), (0.85, 1.1), (1.08, 1.5), (1.10, 1.7), (1.0, 1.8), (0.6, 1.86), (0, 1.89)],
    )  # fmt: skip
    z = np.linspace(0, 0.024, 26)
    thread = np.column_stack([screw * (0.95 + 0.06 * np.sin(z / 0.0006)), z + 0.006])
    base = revolve(np.array([(0, 0), (0.3 * screw, 0), (0.8 * screw, 0.005), *thread, (0, 0.031)]), 32).painted(STEEL)
    glass = np.array(shapes[style]) * radius * (1, ratio) + (0, 0.029)
    steps = np.linspace(0, 1, 30)
    places = np.linspace(0, 1, len(glass))
    fine = np.column_stack([np.interp(steps, places, glass[:, i]) for i in (0, 1)])
    bulb = merge([base, revolve(np.array([(0, 0.029), *fine]), 40).painted(WHITE)])
    return bulb.turned("x", 180) if style == 3 and rng.random() < 0.5 else settled(bulb, 90, 45)
