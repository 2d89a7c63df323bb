"""Phones of one piece: bars with keys, messengers with a keyboard, smartphones bare and in cases."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.cell_phone.body import (
    BEZEL,
    BLACK,
    GLASS,
    LIT,
    SILVER,
    antenna,
    body,
    keypad,
    plate,
    put_down,
    shell_colors,
)
from orbitscan.recorder.simulation.objects.solids import cylinder


def candy_bar(rng: np.random.Generator) -> Mesh:
    """A bar with a small screen above twelve keys, thin or thick, straight or waisted, some with an antenna."""
    shell, trim = shell_colors(rng)
    length, width, thickness = rng.uniform((0.098, 0.042, 0.009), (0.138, 0.056, 0.029))
    corner, lower, upper = rng.uniform((0.005, 0.002, 0.0015), (0.45 * width, 0.009, 0.006))
    lower, upper = np.minimum((lower, upper), 0.45 * thickness)
    barrel, ends = rng.uniform((-0.05, 0), (0.06, 0.04))
    share = rng.uniform(0.30, 0.42)  # of the length, for the screen
    inside = length - 2 * upper - 0.010
    across = 0.78 * (width - 2 * upper)
    bulge = rng.uniform(0.0004, 0.0014)
    top = -inside / 2 + 0.07 * inside
    parts = [
        body(length, width, thickness, corner, (lower, upper), barrel, ends).painted(shell),
        plate(share * inside + 0.006, across + 0.004).moved(top + share * inside / 2, 0, thickness).painted(BEZEL),
        plate(share * inside, across, height=0.0014).moved(top + share * inside / 2, 0, thickness).painted(LIT),
        *_navigation(rng, across, trim, (top + (share + 0.10) * inside, thickness)),
        *(
            key.moved(top + (share + 0.19 + (0.70 - share) / 2) * inside, 0, thickness).painted(trim)
            for key in keypad((0.70 - share) * inside, across, 4, 3, bulge, rng.uniform(0.65, 0.92))
        ),
        plate(0.0012, 0.3 * across, 0.0005, 0.0012).moved(-length / 2 + upper + 0.004, 0, thickness).painted(BLACK),
    ]
    if rng.random() < 0.4:
        side = (width / 2 - max(0.5 * corner, 0.008)) * rng.choice([-1, 1])
        stub = antenna(rng, rng.uniform(0.008, 0.028)).moved(-length / 2 + 0.003, side, 0.55 * thickness)
        parts.append(stub.painted(BLACK if rng.random() < 0.7 else shell))
    return put_down(rng, merge(parts), thickness)


def messenger(rng: np.random.Generator) -> Mesh:
    """A broad bar with a keyboard below a landscape screen."""
    shell, trim = shell_colors(rng)
    length, width, thickness = rng.uniform((0.104, 0.058, 0.0105), (0.122, 0.070, 0.020))
    corner, lower, upper = rng.uniform((0.008, 0.002, 0.0015), (0.020, 0.006, 0.004))
    across = width - 2 * upper - 0.008
    rows = int(rng.integers(3, 5))
    tall = 0.42 * length
    parts = [
        body(length, width, thickness, corner, (lower, upper), rng.uniform(-0.04, 0.05), rng.uniform(0, 0.03)).painted(
            shell
        ),
        plate(tall, across + 0.003, 0.003).moved(-0.21 * length, 0, thickness).painted(GLASS),
        plate(0.8 * tall, 0.88 * across, height=0.0012).moved(-0.21 * length, 0, thickness).painted(LIT),
        *_navigation(rng, across, trim, (0.075 * length, thickness)),
        *(
            key.moved(0.28 * length, 0, thickness).painted(trim)
            for key in keypad(0.29 * length, across, rows, 10, rng.uniform(0.0006, 0.0016), 0.84)
        ),
    ]
    if rng.random() < 0.25:
        stub = antenna(rng, rng.uniform(0.008, 0.022))
        parts.append(stub.moved(-length / 2 + 0.004, 0.34 * width, 0.55 * thickness).painted(BLACK))
    return put_down(rng, merge(parts), thickness)


def smartphone(rng: np.random.Generator) -> Mesh:
    """A slab of glass with rounded corners: small and thick as the first ones, or large and thin."""
    shell, trim = shell_colors(rng)
    size = rng.uniform()
    length = 0.110 + 0.048 * size
    width = length * rng.uniform(0.47, 0.54)
    thickness = 0.0122 - 0.0035 * size + rng.uniform(-0.0015, 0.0015)
    corner, lower, upper = rng.uniform((0.006, 0.0012, 0.0008), (0.014, 0.45 * thickness, 0.0022))
    frame, chin = rng.uniform((0.002, 0.004), (0.005, 0.017))
    parts = [
        body(length, width, thickness, corner, (lower, upper)).painted(shell),
        plate(length - 2 * upper - 0.001, width - 2 * upper - 0.001, corner).moved(z=thickness).painted(BLACK),
        plate(length - 2 * chin, width - 2 * frame, 0.002, 0.0011).moved(z=thickness).painted(GLASS),
        plate(0.0012, 0.010, 0.0005, 0.0012).moved(-length / 2 + 0.6 * chin, 0, thickness).painted(SILVER),
        *_camera(rng, length, width, trim),
    ]
    if chin > 0.010:
        parts.append(cylinder(0.0048, 0.001, 0.0002, 24).moved(length / 2 - chin / 2, 0, thickness).painted(BEZEL))
    return put_down(rng, merge(parts), thickness)


def cased_smartphone(rng: np.random.Generator) -> Mesh:
    """A smartphone in a case: a rim stands up around its screen, or a flap of leather covers it."""
    shell, trim = shell_colors(rng)
    length, ratio, rim = rng.uniform((0.114, 0.48, 0.0008), (0.156, 0.54, 0.0020))
    width, thickness = length * ratio, rng.uniform(0.0105, 0.0165)
    corner, lower = rng.uniform((0.008, 0.002), (0.017, 0.005))
    waves = rng.uniform(-0.03, 0.02) if rng.random() < 0.4 else 0.0
    case = body(length, width, thickness, corner, (lower, 0.0012), waves, lip=rim).painted(shell)
    parts = [case, *_camera(rng, length, width, trim)]
    if rng.random() < 0.35:
        flap = body(length, width * 1.02, 0.0026, corner, (0.0008, 0.0012)).moved(y=width / 2)
        spine = body(length - 2 * corner, thickness, 0.0022, 0.001, (0.001, 0.001)).turned("x", 90)
        parts += [
            flap.turned("x", max(0.0, rng.uniform(-8, 12))).moved(0, -width / 2, thickness).painted(shell),
            spine.moved(0, -width / 2, thickness / 2).painted(shell),
        ]
    else:
        inner = length - 0.0065, width - 0.0065
        parts += [
            plate(*inner, corner - 0.004, 0.0016).moved(z=thickness - rim).painted(BLACK),
            plate(0.84 * inner[0], 0.94 * inner[1], 0.002, 0.0020).moved(z=thickness - rim).painted(GLASS),
        ]
    return put_down(rng, merge(parts), thickness)


def _navigation(
    rng: np.random.Generator, across: float, color: tuple[int, int, int], at: tuple[float, float]
) -> list[Mesh]:
    """The round or square pad between two pairs of keys, at x and z."""
    x, z = at
    if rng.random() < 0.5:
        pad = cylinder(rng.uniform(0.0045, 0.0065), 0.0022, 0.0005, 24).moved(z=-0.001)
    else:
        pad = plate(rng.uniform(0.009, 0.012), rng.uniform(0.009, 0.015), 0.002, 0.0026)
    keys = [
        plate(0.0045, 0.22 * across, 0.001, 0.0018).moved(row, side * 0.37 * across)
        for row in (-0.003, 0.003)
        for side in (-1, 1)
    ]
    return [part.moved(x, 0, z).painted(color) for part in (pad, *keys)]


def _camera(rng: np.random.Generator, length: float, width: float, color: tuple[int, int, int]) -> list[Mesh]:
    """The camera on the back: one lens in a corner or in the middle, or an island of several."""
    x = -length / 2 + rng.uniform(0.016, 0.024)
    y = rng.choice([0.0, width / 2 - 0.016])
    proud = rng.uniform(0.0004, 0.0022)
    lens = cylinder(0.0046, 0.0012, 0.0003, 20)
    if rng.random() < 0.6:
        return [lens.moved(x, y, -proud).painted(GLASS)]
    island = plate(rng.uniform(0.016, 0.026), 0.018, 0.004, 2 * proud).moved(x, y)
    return [
        island.painted(color),
        *(lens.moved(x + step, y, -proud - 0.0004).painted(GLASS) for step in (-0.0052, 0.0052)),
    ]
