"""Phones of two pieces: flip phones shut and open, sliders."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.cell_phone.body import (
    BEZEL,
    BLACK,
    GLASS,
    LIT,
    antenna,
    body,
    keypad,
    plate,
    put_down,
    shell_colors,
)
from orbitscan.recorder.simulation.objects.solids import cylinder


def flip_shut(rng: np.random.Generator) -> Mesh:
    """A flip phone, shut: two shells and the hinge between them at the top, a small screen on the lid."""
    return _flip(rng, 0.0)


def flip_open(rng: np.random.Generator) -> Mesh:
    """A flip phone, open: its keys lie before the reader, its screen rises behind them."""
    return _flip(rng, rng.uniform(148, 174) if rng.random() < 0.75 else rng.uniform(95, 148))


def slider(rng: np.random.Generator) -> Mesh:
    """A slider, shut or pushed up over its keys, or sideways over a keyboard."""
    shell, trim = shell_colors(rng)
    length, width, low, high = rng.uniform((0.092, 0.045, 0.0070, 0.0055), (0.116, 0.056, 0.0110, 0.0090))
    corner, lower, upper = rng.uniform((0.005, 0.0015, 0.001), (0.018, 0.004, 0.003))
    sideways, open_ = rng.random() < 0.35, rng.random() < 0.7
    shift = rng.uniform(0.30, 0.42) * length if not sideways else rng.uniform(0.55, 0.72) * width
    inside = length - 0.012, width - 2 * upper - 0.005
    parts = [body(length, width, low, corner, (lower, 0.001)).painted(shell)]
    lid = [
        body(length, width, high, corner, (0.001, upper)).painted(trim if rng.random() < 0.4 else shell),
        plate(0.70 * inside[0], inside[1], 0.002).moved(-0.08 * length, 0, high).painted(GLASS),
        plate(0.60 * inside[0], 0.88 * inside[1], 0.001, 0.0012).moved(-0.08 * length, 0, high).painted(LIT),
        *(
            key.moved(0.38 * length, 0, high).painted(trim)
            for key in keypad(0.13 * length, 0.9 * inside[1], 2, 3, 0.0008)
        ),
    ]
    x, y = (0.0, 0.0) if not open_ else (0.0, -shift) if sideways else (-shift, 0.0)
    parts += [part.moved(x, y, low + 0.0003) for part in lid]
    if open_ and sideways:
        keys = keypad(0.9 * inside[0], shift - 0.006, 10, 4, 0.0008)
        parts += [key.moved(0, width / 2 - shift / 2, low).painted(trim) for key in keys]
    elif open_:
        keys = keypad(shift - 0.008, 0.9 * inside[1], 4, 3, 0.0008, 0.86)
        parts += [key.moved(length / 2 - shift / 2 - 0.001, 0, low).painted(trim) for key in keys]
    return put_down(rng, merge(parts), low + high)


def _flip(rng: np.random.Generator, opening_deg: float) -> Mesh:
    """A flip phone opened by the angle."""
    shell, trim = shell_colors(rng)
    length, width, low, high = rng.uniform((0.086, 0.044, 0.0075, 0.0060), (0.104, 0.054, 0.0150, 0.0110))
    corner, lower, upper = rng.uniform((0.005, 0.002, 0.0015), (0.45 * width, 0.45 * low, 0.45 * high))
    barrel, ends, shorter = rng.uniform((-0.03, 0, 0.90), (0.05, 0.03, 1.0))
    hinge, across = -length / 2 + 0.004, width - 0.012
    base = [
        body(length, width, low, corner, (lower, 0.0008), barrel, ends).painted(shell),
        cylinder(0.0055, 0.0022, 0.0005, 24).moved(-0.26 * length, 0, low - 0.001).painted(trim),
        *(
            key.moved(0.12 * length, 0, low).painted(trim)
            for key in keypad(0.52 * length, across, 4, 3, rng.uniform(0.0002, 0.0009), rng.uniform(0.7, 0.92))
        ),
        cylinder(max(low, high) * rng.uniform(0.7, 0.95), rng.uniform(0.5, 0.9) * width, 0.0006, 24)
        .turned("x", 90)
        .moved(hinge, 0, low)
        .moved(y=0.35 * width)
        .painted(shell),
    ]
    lid = [
        body(shorter * length, width, high, corner, (0.0008, upper), barrel, ends).painted(
            trim if rng.random() < 0.3 else shell
        ),
        plate(0.66 * length, across, 0.002).painted(BEZEL),
        plate(0.48 * length, 0.9 * across, 0.001, 0.0014).painted(LIT),
        plate(rng.uniform(0.012, 0.026), rng.uniform(0.018, 0.028), 0.003, 0.0012)
        .moved(-0.12 * length, 0, high)
        .painted(GLASS),
        cylinder(0.0035, 0.0014, 0.0004, 20).moved(-0.34 * length, 0, high - 0.0005).painted(BLACK),
    ]
    lid = [part.moved(-(1 - shorter) * length / 2 - hinge).turned("y", -opening_deg).moved(hinge) for part in lid]
    parts = [*base, *(part.moved(z=low + 0.0006) for part in lid)]
    if rng.random() < 0.45:
        side = (width / 2 - 0.007) * rng.choice([-1, 1])
        parts.append(antenna(rng, rng.uniform(0.008, 0.026)).moved(hinge - 0.002, side, low).painted(BLACK))
    flip = merge(parts)
    if opening_deg == 0:
        return put_down(rng, flip, low + high)
    return flip.turned("y", rng.uniform(-3, 3)).turned("x", rng.uniform(-3, 3))
