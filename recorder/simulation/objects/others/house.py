"""What else is found about a house."""

from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.others.bodies import along_x, domed, hoop, lying, rumpled
from orbitscan.recorder.simulation.objects.others.palette import BLACK, GREY, STEEL, WHITE, YELLOW, colors
from orbitscan.recorder.simulation.objects.solids import (
    box,
    circle,
    cylinder,
    ellipsoid,
    loft,
    prism,
    revolve,
    rounded_rectangle,
    sweep,
)


def shoe(rng: np.random.Generator) -> Mesh:
    """A shoe, its toe towards +x: a sneaker, a slip-on or a boot, a child's or a grown-up's."""
    length, slender, sole = rng.uniform((0.15, 0.17, 0.012), (0.30, 0.20, 0.034))
    ankle, boot = rng.uniform(0.30, 0.42) * length, rng.random() < 0.3
    ankle = 1.7 * ankle if boot else ankle
    color, trim = colors(rng, 2)
    angles = 2 * np.pi * np.arange(48) / 48
    x, y = np.cos(angles), np.sin(angles)
    half = slender * length * (1 + 0.14 * x - 0.20 * np.exp(-(((x + 0.15) / 0.35) ** 2)))
    foot = np.column_stack([length / 2 * x, np.sign(y) * np.abs(y) ** 0.8 * half + 0.03 * length * x**2 * (x > 0)])
    rise = rng.uniform(0.4, 0.8)  # 1.2: the instep is straight
    opening = foot * (0.48, 0.70) + (-0.24 * length, 0)
    rings = [np.column_stack([foot * 0.99, np.full(48, 0.5 * sole)])]
    for t in np.linspace(0, np.pi / 2, 14):
        near, up = 1 - np.cos(t) ** 1.1, np.sin(t) ** (0.8 + rise * np.clip(x, 0, 1))
        rings.append(np.column_stack([foot + (opening - foot) * near, sole + (ankle - sole) * up]))
    for inset, down in ((0.94, 0), (0.92, 0.3), (0.88, 0.6), (0.84, 0.75)):
        hole = (opening - opening.mean(axis=0)) * inset + opening.mean(axis=0)
        rings.append(np.column_stack([hole, np.full(48, ankle - down * (ankle - sole))]))
    upper = np.stack(rings)
    upper[..., 2] += 0.10 * ankle * (upper[..., 2] / ankle) ** 4 * (0.5 - upper[..., 0] / length)  # higher at the heel
    slab = prism(foot * 1.03, sole, 0.002)
    s = np.linspace(-1, 1, 9)[:, None]
    laces = []
    for share in np.linspace(0.04, 0.20, 4) if rng.random() < 0.6 else ():
        z = np.interp(share * length, upper[1:15, 0, 0][::-1], upper[1:15, 0, 2][::-1])
        path = np.hstack([0 * s + share * length, 0.08 * length * s, z - 0.001 - 0.035 * length * s**2])
        laces.append(sweep(circle(0.003, 8), path).painted(WHITE))
    return merge([loft(upper).painted(color), slab.painted(trim), *laces])


def toy_car(rng: np.random.Generator) -> Mesh:
    """A toy car, its front towards +x: a saloon, a van, a pickup or a racing car."""
    style, length = rng.integers(4), rng.uniform(0.07, 0.24)
    color, trim = colors(rng, 2)
    half, floor, deck = rng.uniform((0.19, 0.05, 0.17), (0.24, 0.07, 0.22)) * length
    wheel = rng.uniform(0.075, 0.105) * length
    s = np.linspace(0, 1, 24)
    ends = np.clip(1 - np.abs(2 * s - 1) ** 8, 0.15, 1) ** 0.4
    bonnet = np.interp(s, [0, 0.6, 1], [1, 1, (0.75, 1, 0.9, 0.45)[style]])
    hull = domed(half, deck - floor, 4.5) * np.stack([ends, ends * bonnet], axis=1)[:, None]
    parts = [along_x(length * (s - 0.5), hull).moved(z=floor).painted(color)]
    rear, front, roof = ((-0.32, 0.22, 0.15), (-0.46, 0.40, 0.22), (-0.05, 0.25, 0.17), (-0.18, 0.06, 0.07))[style]
    roof *= length * rng.uniform(0.85, 1.15)
    cabin = rounded_rectangle((front - rear) * length, 1.85 * half, 0.02 * length, 6)
    narrow = np.array([rng.uniform(0.55, 0.75) if style != 1 else 0.93, 0.85])
    levels = [(cabin, 0.0), (cabin * narrow, 0.92 * roof), (0.9 * cabin * narrow, roof)]
    glass = loft(np.stack([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in levels]))
    windows = np.where(glass.vertices[:, 2:] < 0.7 * roof, (150, 176, 190), color).astype(np.uint8)
    parts.append(replace(glass, colors=windows).moved((rear + front) / 2 * length, 0, deck - 0.004))
    if style == 3:
        parts.append(
            box(0.06 * length, 2 * half, 0.012 * length).moved(-0.46 * length, 0, deck + 0.10 * length).painted(trim)
        )
        parts.append(box(0.02 * length, 0.3 * half, 0.12 * length).moved(-0.46 * length, 0, deck - 0.01).painted(trim))
    tyre = cylinder(wheel, 0.10 * length, 0.01 * length, 28).moved(z=-0.05 * length).turned("x", 90).painted(BLACK)
    hub = cylinder(0.5 * wheel, 0.115 * length, 0.002, 16).moved(z=-0.0575 * length).turned("x", 90).painted(STEEL)
    for x in (-0.30, 0.30):
        for side in (-1, 1):
            parts += [part.moved(x * length, side * 0.90 * half, wheel) for part in (tyre, hub)]
    return merge(parts)


def ball(rng: np.random.Generator) -> Mesh:
    """A ball on a stand: a globe in its bow, a football on a ring with legs, a trophy on a column."""
    style, radius, squash = rng.integers(3), rng.uniform(0.035, 0.10), rng.uniform(0.75, 1.3)
    color, trim = colors(rng, 2)
    sphere = ellipsoid(radius, radius, radius * (squash if style else 1), 36)
    x, y, z = (sphere.vertices / radius).T
    patches = np.sin(5 * x + 1) * np.sin(5 * y) * np.sin(5 * z + 2) > 0.1
    sphere = replace(sphere, colors=np.where(patches[:, None], color, trim).astype(np.uint8))
    rise = radius * rng.uniform(0.6, 1.6)
    if style == 0:
        angles = np.radians(np.linspace(-80, 80, 36))
        bow = 1.12 * radius * np.column_stack([np.cos(angles), 0 * angles, np.sin(angles)])
        arc = sweep(rounded_rectangle(0.05 * radius, 0.14 * radius, 0.015 * radius, 3), bow, up=(0, 1, 0)).turned(
            "y", 23
        )
        foot = [(0, 0), (0.75, 0), (0.75, 0.08), (0.2, 0.2), (0.1, 0.35), (0.1, 1), (0, 1)]
        stand = revolve(np.array(foot) * (radius, 0.9 * rise), 36).moved(z=-1.05 * radius - 0.9 * rise)
        return merge([sphere.turned("y", 23), arc.painted(STEEL), stand.painted(BLACK)])
    low = -radius * squash
    if style == 1:
        ring = hoop(circle(0.05 * radius, 10), 0.72 * radius, 0.72 * radius).moved(z=0.70 * low).painted(GREY)
        leg = cylinder(0.05 * radius, rise, segments=12).turned("y", -14)
        leg = leg.moved(0.95 * radius, 0, 0.70 * low - 0.97 * rise).painted(GREY)
        legs = [leg.turned("z", turn) for turn in (30, 150, 270)]
        return merge([sphere, ring, *legs])
    column = [(0, 0), (0.8, 0), (0.8, 0.15), (0.3, 0.3), (0.2, 0.7), (0.35, 1), (0.3, 1.1), (0, 1.1)]
    return merge([sphere, revolve(np.array(column) * (radius, rise), 36).moved(z=low - rise).painted(BLACK)])


def comb(rng: np.random.Generator) -> Mesh:
    """A comb lying flat, its teeth towards +y, with a handle or without; or a hairbrush on its back."""
    length, tooth, spine = rng.uniform((0.12, 0.020, 0.008), (0.21, 0.038, 0.016))
    color, trim = colors(rng, 2)
    grip = rng.choice([0, 0.35]) * length
    if rng.random() < 0.4:
        width, deep = rng.uniform((0.02, 0.008), (0.035, 0.018))
        s = np.linspace(-1, 1, 24)
        half = np.interp(s, [-1, -0.9, -0.1, 0.05, 0.9, 1], [0.4, 0.6, 0.45, 0.9, 1, 0.5])
        back = along_x(0.6 * length * s, domed(width, deep, 2.6) * np.stack([half, 0 * s + 1], axis=1)[:, None])
        places = [(x, y) for x in np.linspace(0.06, 0.55, 14) * length for y in np.linspace(-0.75, 0.75, 5) * width]
        bristles = [cylinder(0.0012, 0.014 + deep, segments=6).moved(x, y, 0.002) for x, y in places]
        return merge([back.painted(color), *(bristle.painted(trim) for bristle in bristles)])
    bar = box(length + grip, spine, 0.0045, 0.001).moved(-grip / 2, -spine / 2)
    pitch = rng.uniform(0.0028, 0.0045)
    teeth = [box(0.55 * pitch, tooth, 0.003).moved(x, tooth / 2 - 0.001, 0.0007)
             for x in np.arange(-length / 2 + 0.004, length / 2 - 0.003, pitch)]  # fmt: skip
    ends = [box(0.006, tooth, 0.0045, 0.001).moved(side * (length / 2 - 0.003), tooth / 2 - 0.001) for side in (-1, 1)]
    return merge([bar.painted(color), *(part.painted(trim) for part in (*teeth, *ends))])


def toothbrush(rng: np.random.Generator) -> Mesh:
    """A toothbrush, its bristles towards +x: lying on its back or on a side, straight or bent at the neck."""
    length, grip, bend = rng.uniform((0.155, 0.0055, -0.010), (0.20, 0.0085, 0.010))
    color, trim = colors(rng, 2)
    s = np.linspace(0, 1, 48)
    curve = bend * np.sin(np.pi * s) + 0.5 * bend * np.clip(s - 0.7, 0, 1)
    wide = np.interp(s, [0, 0.04, 0.3, 0.6, 0.72, 0.84, 0.88, 0.98, 1], [0.6, 1, 1.2, 0.9, 0.5, 0.5, 1, 1, 0.6])
    flat = np.interp(s, [0, 0.04, 0.3, 0.6, 0.72, 0.84, 1], [0.6, 1, 1.1, 0.9, 0.5, 0.35, 0.35])
    path = np.column_stack([length * (s - 0.5), 0 * s, curve])
    stem = sweep(circle(grip, 20) * (1, 0.85), path, scales=np.column_stack([wide, flat]))
    tuft = rng.uniform(0.010, 0.013)
    places = [(x, y) for x in np.linspace(0.39, 0.485, 9) for y in np.linspace(-0.0042, 0.0042, 4)]
    head = [box(0.0022, 0.0022, tuft + 0.001 * np.cos(9 * x)).moved(x * length, y, curve[-5]) for x, y in places]
    whole = merge([stem.painted(color), *(part.painted(trim if i % 3 else WHITE) for i, part in enumerate(head))])
    return whole.turned("x", rng.choice([0, 90, 180]) + rng.uniform(-15, 15))


def sponge(rng: np.random.Generator) -> Mesh:
    """A kitchen sponge with a rough layer, a waisted one or a thick one for the car."""
    length, width, height = rng.uniform((0.085, 0.055, 0.020), (0.13, 0.080, 0.038))
    if rng.random() < 0.3:
        length, width, height = rng.uniform((0.15, 0.09, 0.045), (0.21, 0.13, 0.07))
    waist = rng.choice([0, 0.14, 0.25])
    color, trim = colors(rng, 2)
    outline = rounded_rectangle(length, width, rng.uniform(0.003, 0.25 * width), 10)
    share = np.arange(len(outline) * 3) / 3
    outline = np.column_stack(
        [np.interp(share, np.arange(len(outline)), outline[:, i], period=len(outline)) for i in (0, 1)]
    )
    outline[:, 1] *= 1 - waist * np.exp(-((outline[:, 0] / (0.22 * length)) ** 2))
    soft = rumpled(rng, prism(outline, height, 0.004), rng.uniform(0.001, 0.004), 2.0)
    rough = prism(1.01 * outline, 0.008).moved(z=height - 0.004)
    whole = merge([soft.painted(YELLOW if rng.random() < 0.4 and trim != YELLOW else color), rough.painted(trim)])
    return whole.turned("x", 90) if rng.random() < 0.2 and not waist else whole.turned("x", rng.choice([0, 180]))


def hand_towel(rng: np.random.Generator) -> Mesh:
    """A towel: dropped in a heap, rolled up, or folded to a stack."""
    style, (color, trim) = rng.integers(3), colors(rng, 2)
    if style == 0:
        radius, height = rng.uniform((0.08, 0.05), (0.14, 0.11))
        turns = np.linspace(0, np.pi / 2, 28)
        profile = np.column_stack([radius * np.cos(turns) ** 0.7, height * np.sin(turns)])
        profile[-1, 0] = 0
        heap = revolve(np.array([(0, 0), *profile]), 64)
        x, y, z = heap.vertices.T
        folds = 1 + rng.uniform(0.10, 0.22) * np.sin(rng.integers(4, 8) * np.arctan2(y, x) + 2 * z / height)
        heap = replace(heap, vertices=heap.vertices * np.column_stack([folds, folds, np.ones_like(folds)]))
        heap = rumpled(rng, rumpled(rng, heap, 0.016, 1.2), 0.005, 3)
        stripes = np.abs(np.sin(heap.vertices[:, :1] / 0.02)) < 0.2
        return replace(heap, colors=np.where(stripes, trim, color).astype(np.uint8))
    length, width, thick = rng.uniform((0.16, 0.10, 0.010), (0.30, 0.19, 0.022))
    if style == 1:
        turn = np.linspace(0, 2 * np.pi * rng.uniform(2, 3), 90)
        radius = 0.006 + thick * turn / (2 * np.pi)
        roll = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), 0 * turn])
        sheet = sweep(rounded_rectangle(0.8 * thick, length, 0.3 * thick, 3), roll).painted(color)
        band = cylinder(radius[-1] + 0.42 * thick, 0.04, 0.002, 48).moved(z=-0.02).painted(trim)
        return lying(rumpled(rng, merge([sheet, band]), 0.004))
    s = np.linspace(-1, 1, 30)
    layers = []
    for layer in range(rng.integers(2, 5)):
        ends = np.clip(1 - np.abs(s) ** 10, 0.05, 1) ** 0.5
        slab = along_x(
            length / 2 * s, domed(width / 2, thick, 3.5, 40, 0.0) * np.stack([0 * s + 1, ends], axis=1)[:, None]
        )
        slab = rumpled(rng, slab, 0.005)
        x, y = rng.uniform(-0.006, 0.006, 2)
        slab = slab.moved(x, y, 0.92 * thick * layer)
        layers.append(slab.painted(color if layer % 2 == 0 else trim))
    return merge(layers).turned("z", rng.uniform(-15, 15))
