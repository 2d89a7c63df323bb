"""What lies about on a desk."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.others.bodies import along_x, domed, hoop, lying
from orbitscan.recorder.simulation.objects.others.palette import STEEL, WHITE, colors
from orbitscan.recorder.simulation.objects.solids import box, circle, cylinder, prism, revolve, rounded_rectangle
from orbitscan.recorder.simulation.objects.vessel import polygon


def marker(rng: np.random.Generator) -> Mesh:
    """A felt pen, a marker or a highlighter lying, capped, or its cap on its tail and the tip bare."""
    length, radius, capped = rng.uniform(0.115, 0.150), rng.uniform(0.0055, 0.0125), rng.random() < 0.7
    body, color = colors(rng, 2)
    outline = (circle(1, 32), circle(1, 32) * (1.5, 0.85), polygon(6, 36))[rng.integers(3)]
    parts = [prism(radius * outline, 0.70 * length, 0.001).painted(body)]
    cap = prism(1.10 * radius * outline, 0.34 * length, 0.0015).painted(color)
    clip = box(0.002, 0.005, 0.25 * length).moved(1.2 * radius * np.ptp(outline[:, 0]) / 2, 0, 0.04 * length)
    cap = merge([cap, clip.painted(color)]) if rng.random() < 0.6 else cap
    if capped:
        parts += [cap.moved(z=0.66 * length), cylinder(0.8 * radius, 0.01).moved(z=-0.008).painted(color)]
    else:
        cone = [(0, 0), (0.9, 0), (0.85, 0.35), (0.45, 0.62), (0.40, 0.78), (0.12, 0.95), (0, 1)]
        parts += [cap.turned("x", 180).moved(z=0.22 * length), revolve(np.array(cone) * (radius, 0.2 * length), 28)
                  .moved(z=0.69 * length).painted(color)]  # fmt: skip
    return lying(merge(parts).turned("z", rng.uniform(-40, 40))).turned("z", rng.uniform(-15, 15))


def stapler(rng: np.random.Generator) -> Mesh:
    """A stapler at rest, its mouth open by a few degrees or thrown open; long or compact."""
    length, half, height = rng.uniform((0.09, 0.013, 0.012), (0.19, 0.022, 0.024))
    color, trim = colors(rng, 2)
    s = np.linspace(0, 1, 30)
    crown = np.interp(s, [0, 0.08, 0.35, 0.8, 0.95, 1], [0.55, 0.85, 1.15, 1.0, 0.75, 0.45]) * rng.uniform(1, 1.5)
    wide = np.interp(s, [0, 0.1, 0.9, 1], [0.75, 1, 1, 0.7])
    arm = along_x(length * s, domed(half, height, 3.2) * np.stack([wide, crown], axis=1)[:, None])
    magazine = box(0.94 * length, 1.2 * half, 0.009).moved(0.48 * length, 0, -0.008)
    opening = rng.uniform(4, 11) if rng.random() < 0.8 else rng.uniform(35, 80)
    upper = merge([arm.painted(color), magazine.painted(STEEL)]).turned("y", -opening)
    base = along_x(length * 1.02 * s, domed(1.05 * half, 0.011, 4) * np.stack([wide, 0 * s + 1], axis=1)[:, None])
    anvil = box(0.018, 1.1 * half, 0.003).moved(0.88 * length, 0, 0.0095).painted(STEEL)
    hinge = box(0.030, 1.75 * half, 0.022, 0.002).moved(0.016, 0, 0.006)
    return merge([upper.moved(0.004, 0, 0.020), base.painted(trim), anvil, hinge.painted(trim)])


def tape_roll(rng: np.random.Generator) -> Mesh:
    """A roll of tape, flat or on its edge: thin or thick, on a core of card, or in a dispenser."""
    core, thick, width = rng.uniform((0.012, 0.004, 0.012), (0.040, 0.026, 0.055))
    color, trim = colors(rng, 2)
    middle = core + thick / 2
    tape = hoop(rounded_rectangle(thick, width, 0.0008, 3), middle, middle, 72).painted(color)
    card = hoop(rounded_rectangle(0.003, width + 0.001, 0.0005, 3), core, core, 72).painted((206, 180, 140))
    roll = merge([tape, card])
    if rng.random() < 0.4:
        return roll
    upright = roll.turned("x", 90)
    if rng.random() < 0.5:
        return upright
    outer = core + thick
    base = np.array([(-1.15, 0), (2.5, 0), (2.7, 0.95), (2.3, 0.95), (1.2, 0.40), (-1.15, 0.40)]) * outer
    shell = along_x(np.linspace(-0.5, 0.5, 5) * (width + 0.014), np.broadcast_to(base, (5, 6, 2))).turned("z", -90)
    return merge([upright, shell.moved(z=-1.1 * outer).painted(trim)])


def calculator(rng: np.random.Generator) -> Mesh:
    """A calculator: a wedge or a slab with a display and rows of keys, some with a display that stands up."""
    long, wide = rng.uniform((0.10, 0.065), (0.20, 0.15))
    wide = min(wide, 0.85 * long)
    back = rng.uniform(0.010, 0.035)
    front = rng.uniform(0.006, 0.010) if back > 0.014 else back
    case, keys, display = colors(rng, 3)
    slope = np.degrees(np.arctan2(back - front, long))
    outline = np.array([(long / 2, 0), (long / 2, front), (-long / 2, back), (-long / 2, 0)])
    y = np.linspace(-1, 1, 9) * wide / 2
    body = along_x(y, np.broadcast_to(outline, (9, 4, 2))).turned("z", -90).painted(case)
    top = []
    rows, columns = rng.integers(4, 8), rng.integers(4, 7)
    field, pitch = 0.62 * long, 0.90 * wide / columns
    for row in range(rows):
        for column in range(columns):
            key = box(0.72 * field / rows, 0.78 * pitch, 0.0045)
            place = (0.47 * long - (row + 0.5) * field / rows, (column - (columns - 1) / 2) * pitch, -0.002)
            top.append(key.moved(*place).painted(keys if (row + column) % 5 else WHITE))
    screen = box(0.22 * long, 0.84 * wide, 0.003)
    tilt = rng.uniform(15, 60) if rng.random() < 0.3 else 0
    screen = box(0.24 * long, 0.86 * wide, 0.012, 0.001) if tilt else screen
    top.append(
        screen.turned("y", tilt).moved(-0.34 * long, 0, -0.001 + 0.1 * long * np.sin(np.radians(tilt))).painted(display)
    )
    return merge([body, merge(top).turned("y", slope).moved(z=(front + back) / 2)])
