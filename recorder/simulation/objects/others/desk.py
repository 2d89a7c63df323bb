"""Things with a plug or a battery."""

from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.others.bodies import along_x, carton, domed, hoop, lying
from orbitscan.recorder.simulation.objects.others.palette import BLACK, GREY, SKY, STEEL, WHITE, colors
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

BOARDS = (
    (15, 0.0),
    (18.5, 1.0),
    (22.5, 1.0),
    (14, 0.0),
    (16, 1.0),
)  # keys wide, and whether a row of F keys is set off


def keyboard(rng: np.random.Generator) -> Mesh:
    """A keyboard, full or compact, flat or steep, the space bar towards +x."""
    columns, apart = BOARDS[rng.integers(len(BOARDS))]
    pitch, margin, thick, lift = rng.uniform((0.0165, 0.003, 0.006, 0.0), (0.0195, 0.016, 0.020, 7.0))
    cap, tall = rng.uniform((0.78, 0.0015), (0.92, 0.009))
    case, keys = ((BLACK, GREY), (WHITE, GREY), (GREY, BLACK), (STEEL, WHITE), (BLACK, WHITE))[rng.integers(5)]
    rows = 5 + (rng.random() < 0.75)
    depth, width = rows * pitch + 0.3 * apart * pitch + 2 * margin, columns * pitch + 2 * margin
    palm = rng.choice([0, 0, 0.06])
    body = carton(depth, width, thick)
    parts = [body.painted(case)]
    for row in range(rows):
        x = depth / 2 - margin - (row + 0.5) * pitch - (0.3 * apart * pitch if row == 5 else 0)
        y = -width / 2 + margin
        while y < width / 2 - margin - 0.4 * pitch:
            wide = 6 if row == 0 and abs(y + 0.5 * width - margin - 4 * pitch) < 0.6 * pitch else 1
            gap = 0.5 * pitch if columns > 17 and abs(y + 0.5 * width - margin - 15 * pitch) < 0.01 else 0
            key = box(cap * pitch, (wide - 1 + cap) * pitch, tall + 0.001)
            parts.append(key.moved(x, y + gap + wide * pitch / 2, thick - 0.001).painted(keys))
            y += wide * pitch + gap
    if palm:
        rest = prism(rounded_rectangle(palm, width, 0.01, 6), 0.8 * thick, 0.002)
        parts.append(rest.moved(depth / 2 + palm / 2 - 0.002).painted(case))
    return merge(parts).turned("y", lift)


def computer_mouse(rng: np.random.Generator) -> Mesh:
    """A mouse, low or high, with a wheel; with a cord or without; its buttons towards +x."""
    length, half, height = rng.uniform((0.090, 0.027, 0.024), (0.128, 0.036, 0.044))
    hump, square, waist = rng.uniform((0.30, 2.2, 0.0), (0.50, 3.4, 0.14))
    color, trim = ((BLACK, GREY), (WHITE, GREY), (GREY, BLACK), colors(rng, 2))[rng.integers(4)]
    s = np.linspace(0, 1, 40)
    ends = np.clip(1 - np.abs(2 * s - 1) ** 4.5, 0.02, None) ** 0.5
    wide = ends * (1 - waist * np.exp(-(((s - 0.55) / 0.18) ** 2)))
    rise = ends * np.where(s < hump, 1, 1 - 0.5 * (np.maximum(s - hump, 0) / (1 - hump)) ** 1.6)
    shell = along_x(length * (s - 0.5), domed(half, height, square, 40) * np.stack([wide, rise], axis=1)[:, None])
    base = prism(circle(1, 40) * (0.44 * length, 0.8 * half), 0.003).moved(z=-0.0015).painted(trim)
    top = height * np.interp(0.80, s, rise)
    wheel = cylinder(0.011, 0.006, 0.001, 28).moved(z=-0.003).turned("x", 90).moved(0.30 * length, 0, top - 0.008)
    parts = [shell.painted(color), base, wheel.painted(trim)]
    if rng.random() < 0.45:
        t = np.linspace(0, 1, 40)
        bend, reach = rng.uniform((-0.05, 0.03), (0.05, 0.10))
        path = np.column_stack([0.48 * length + reach * t, bend * np.sin(2.5 * t) * t, np.full(40, 0.003)])
        parts.append(sweep(circle(0.0019, 10), path).painted(trim))
    return merge(parts)


def camera(rng: np.random.Generator) -> Mesh:
    """A camera, its lens towards +x: a compact one, a reflex with a grip and a hump, or a rangefinder."""
    style = rng.integers(3)
    low, high = (((0.022, 0.085, 0.050), (0.034, 0.115, 0.068)), ((0.045, 0.11, 0.070), (0.065, 0.15, 0.095)),
                 ((0.030, 0.11, 0.060), (0.042, 0.14, 0.078)))[style]  # fmt: skip
    depth, width, height = rng.uniform(low, high)
    color, trim = ((BLACK, GREY), (GREY, BLACK), (STEEL, BLACK), colors(rng, 2))[rng.integers(4)]
    lens = rng.uniform(*((0.016, 0.024), (0.028, 0.038), (0.022, 0.030))[style])
    lens, reach = min(lens, 0.46 * height), rng.uniform(*((0.006, 0.032), (0.035, 0.12), (0.018, 0.05))[style])
    barrel = [(0, 0), (lens, 0), (lens, 0.5 * reach), (0.92 * lens, 0.55 * reach), (0.92 * lens, reach)]
    glass = [(0.80 * lens, reach), (0.7 * lens, reach - 0.004), (0, reach - 0.002)]
    tube = lying(revolve(np.array(barrel + glass), 44))
    y = rng.uniform(-0.12, 0.12) * width
    outline = rounded_rectangle(depth, width, 0.3 * depth, 8)
    body = prism(outline, height, 0.002)
    parts = [body.painted(color), tube.moved(depth / 2 - 0.001, y, 0.48 * height).painted(trim)]
    parts.append(prism(1.01 * outline, 0.55 * height).moved(z=0.15 * height).painted(trim))
    parts.append(cylinder(0.006, 0.005, 0.001).moved(0, 0.36 * width, height - 0.001).painted(STEEL))
    if style == 1:
        grip = prism(rounded_rectangle(0.6 * depth, 0.18 * width, 0.008, 6), 0.95 * height, 0.003)
        hump = prism(rounded_rectangle(0.8 * depth, 0.36 * width, 0.01, 6), 0.24 * height, 0.006)
        parts += [
            grip.moved(0.45 * depth, -0.42 * width).painted(trim),
            hump.moved(0.05 * depth, y, 0.96 * height).painted(color),
        ]
    elif style == 2:
        parts.append(box(0.5 * depth, 0.16 * width, 0.010, 0.001).moved(0, y, height - 0.001).painted(trim))
    flash = box(0.003, 0.15 * width, 0.12 * height).moved(depth / 2 - 0.001, 0.36 * width, 0.75 * height)
    return merge([*parts, flash.painted(WHITE)]).turned("z", rng.uniform(-10, 10))


def headphones(rng: np.random.Generator) -> Mesh:
    """Headphones standing on their ear cups, or lying on one side."""
    half, rise, cup, thick = rng.uniform((0.065, 0.15, 0.028, 0.018), (0.085, 0.19, 0.046, 0.036))
    color, trim = colors(rng, 2)
    angles = np.linspace(0, np.pi, 48)
    path = np.column_stack([0 * angles, half * np.cos(angles), cup + (rise - cup) * np.sin(angles) ** 0.8])
    band = sweep(rounded_rectangle(0.007, rng.uniform(0.014, 0.034), 0.003, 3), path, up=(1, 0, 0)).painted(color)
    parts = [band]
    tall = rng.uniform(1, 1.25)
    for side in (-1, 1):
        shell = revolve(np.array([(0, 0), (cup, 0), (cup, 0.5 * thick), (0.75 * cup, thick), (0, thick)]), 40)
        pad = hoop(circle(0.30 * cup, 14), 0.68 * cup, 0.68 * cup).painted(trim)
        ear = merge([shell.painted(color), pad])
        ear = replace(ear, vertices=ear.vertices * (tall, 1, 1)).turned("x", -90 * side).turned("y", 90)
        parts.append(ear.moved(0, side * half, cup))
    whole = merge(parts)
    return whole.turned("y", 90) if rng.random() < 0.4 else whole


def desk_lamp(rng: np.random.Generator) -> Mesh:
    """A lamp on a foot: a jointed arm with a reflector, or a stem with a shade."""
    foot, low, high = rng.uniform((0.055, 0.14, 0.13), (0.085, 0.24, 0.22))
    color, trim = colors(rng, 2)
    base = revolve(np.array([(0, 0), (foot, 0), (foot, 0.008), (0.4 * foot, 0.018), (0, 0.020)]), 48).painted(color)
    if rng.random() < 0.5:
        top, wide = rng.uniform((0.045, 0.075), (0.09, 0.12))
        tall = rng.uniform(0.10, 0.17)
        shade = revolve(np.array([(0, 0), (wide, 0), (top, tall), (0.95 * top, tall), (0, tall - 0.02)]), 56)
        stem = cylinder(0.009, low + 0.02, 0.001).painted(trim)
        return merge([base, stem, shade.moved(z=low).painted(SKY if rng.random() < 0.3 else WHITE)])
    lean, nod = np.radians(rng.uniform((-35, 20), (-5, 75)))
    elbow = np.array([low * np.sin(lean), 0, low * np.cos(lean)])
    wrist = elbow + high * np.array([np.cos(np.pi / 2 - nod), 0, np.sin(np.pi / 2 - nod)])
    s = np.linspace(0, 1, 8)[:, None]
    arms = [
        sweep(circle(0.006, 14), (1 - s) * a + s * b, up=(0, 1, 0)) for a, b in (((0, 0, 0.01), elbow), (elbow, wrist))
    ]
    wide, tall = rng.uniform((0.040, 0.06), (0.065, 0.10))
    bell = [
        (0, 0),
        (0.3 * wide, 0),
        (0.45 * wide, 0.3 * tall),
        (wide, tall),
        (wide - 0.002, tall),
        (0.3 * wide, 0.35 * tall),
    ]
    head = revolve(np.array([*bell, (0, 0.35 * tall)]), 44).turned("y", 180 - rng.uniform(10, 50)).moved(*wrist)
    joint = ellipsoid(0.011, 0.014, 0.011, 16).moved(*elbow)
    return merge([base, *(arm.painted(trim) for arm in arms), head.painted(color), joint.painted(BLACK)])
