"""Canister vacuum cleaners: a body on two big wheels and a caster, the hose, the pipe parked upright behind."""

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.solids import (
    box,
    circle,
    cylinder,
    loft,
    prism,
    revolve,
    rounded_rectangle,
    sweep,
)

BLACK, DARK, GREY, SILVER = (58, 60, 66), (88, 92, 100), (144, 148, 154), (200, 204, 208)
RED, BLUE, GREEN, PURPLE, ORANGE, WHITE = (
    (188, 42, 46),
    (46, 98, 170),
    (82, 146, 96),
    (122, 72, 140),
    (226, 118, 44),
    (230, 230, 226),
)
PAINTS = (RED, BLUE, GREEN, PURPLE, ORANGE, WHITE, GREY)
CLEAR = (162, 186, 196)  # the dust container
FLOOR = 0.030  # of the body above the ground [m]


def build(rng: np.random.Generator) -> Mesh:
    """A vacuum cleaner 40 to 46 cm high; instances differ in body, wheels, hose, dust container and paint."""
    length, width, height, wheel = rng.uniform((0.26, 0.090, 0.135, 0.058), (0.31, 0.110, 0.165, 0.078))
    paint = PAINTS[rng.integers(len(PAINTS))]
    pipe, aside, sag = rng.uniform((0.36, -0.03, 0.05), (0.41, 0.03, 0.11))
    foot = np.array([-0.5 * length - 0.035, aside, 0.0])
    socket = np.array([0.34 * length, -0.30 * width, FLOOR + 0.70 * height])
    parts = [
        *_body(length, width, height, paint),
        *(part.moved(-0.24 * length, 0, wheel) for part in _wheels(wheel, width, paint)),
        *_caster(0.33 * length),
        *_top(rng, length, width, height),
        *(part.moved(*foot) for part in _pipe(pipe, float(rng.uniform(60, 120)), paint)),
        *_hose(socket, foot + np.array([0.085, 0, pipe + 0.012]), sag * (1 if rng.random() < 0.5 else -1)),
    ]
    return merge(parts)


def _body(length: float, width: float, height: float, paint: tuple[int, int, int]) -> list[Mesh]:
    """The housing, higher behind than in front, in a bumper, with a seam where it opens."""
    x = length / 2 * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 27))
    share = x / length
    bulge = np.clip(1 - (2 * np.abs(share)) ** 3.2, 0, 1) ** (1 / 2.4)
    top = PchipInterpolator([-0.5, -0.30, 0.05, 0.35, 0.5], np.array([0.72, 1.0, 0.86, 0.66, 0.50]) * height)(share)
    angle = 2 * np.pi * np.arange(36) / 36
    outline = np.column_stack([np.cos(angle), np.sin(angle)])
    outline = np.sign(outline) * np.abs(outline) ** 0.62
    belly = 0.36 * height  # where the housing is widest and longest
    y = width * (0.06 + 0.94 * bulge)[:, None] * outline[:, 0]
    up, down = (top - belly) * (0.15 + 0.85 * bulge), belly * (0.15 + 0.85 * bulge)
    z = belly + np.where(outline[:, 1] > 0, up[:, None], down[:, None]) * outline[:, 1]
    skin = loft(np.stack([np.broadcast_to(x[:, None], y.shape), y, z], axis=2))
    colors = np.where((skin.vertices[:, 2] < belly - 0.001)[:, None], np.array(DARK), np.array(paint))
    skin = Mesh(skin.vertices, skin.triangles, colors.astype(np.uint8))
    around = np.concatenate([np.column_stack([x, y[:, 0]]), np.column_stack([x, y[:, 18]])[::-1]])
    rim = [around * grown for grown in (0.98, 1.02, 1.03, 1.02, 0.98)]
    bumper = loft(
        [
            np.column_stack([ring, np.full(len(ring), belly + h)])
            for ring, h in zip(rim, np.linspace(-0.012, 0.012, 5), strict=True)
        ]
    )
    return [skin.moved(z=FLOOR), bumper.moved(z=FLOOR).painted(BLACK)]


def _wheels(radius: float, width: float, paint: tuple[int, int, int]) -> list[Mesh]:
    """Two big wheels at the sides: tyre, dished disc with five holes painted on, hub."""
    tyre = np.array(
        [
            (0, 0),
            (0.80, 0),
            (0.95, 0.10),
            (1, 0.35),
            (1, 0.75),
            (0.94, 0.95),
            (0.84, 1.0),
            (0.78, 0.80),
            (0.35, 0.62),
            (0, 0.62),
        ]
    )
    hole = cylinder(0.14 * radius, 0.004, 0, 10).moved(0.56 * radius, 0, 0.026)
    hub = cylinder(0.26 * radius, 0.012, 0.003, 20).moved(z=0.024)
    disc = cylinder(0.76 * radius, 0.004, 0, 32).moved(z=0.0245)
    wheel = [revolve(tyre * (radius, 0.036), 32).painted(BLACK), disc.painted(GREY), hub.painted(paint)]
    wheel += [hole.turned("z", 72 * k).painted(DARK) for k in range(5)]
    left = [part.turned("x", -90).moved(y=width - 0.014) for part in wheel]
    return [*left, *(part.turned("z", 180) for part in left)]


def _caster(x: float) -> list[Mesh]:
    """The swivelling wheel under the front, turned aside."""
    roller = cylinder(0.017, 0.016, 0.003, 20).moved(z=-0.008).turned("x", 90).moved(-0.008, 0, 0.017)
    fork = box(0.026, 0.026, 0.016, 0.003).moved(z=0.022)
    return [part.turned("z", 35).moved(x) for part in (roller.painted(BLACK), fork.painted(GREY))]


def _top(rng: np.random.Generator, length: float, width: float, height: float) -> list[Mesh]:
    """What is on the housing: a carrying handle, pedals for power and cable, and a dust container or a grille."""
    top = FLOOR + height
    angles = np.linspace(0, np.pi, 17)
    bow = np.column_stack(
        [-0.12 * length + 0.26 * length * np.cos(angles), 0 * angles, top - 0.030 + 0.062 * np.sin(angles) ** 0.7]
    )
    parts = [
        sweep(rounded_rectangle(0.026, 0.013, 0.005, 3), bow, up=(0, 1, 0)).painted(DARK),
        cylinder(0.018, 0.014, 0.003, 20).moved(-0.33 * length, 0.52 * width, top - 0.020).painted(RED),
        cylinder(0.018, 0.012, 0.003, 20).moved(-0.33 * length, -0.52 * width, top - 0.020).painted(SILVER),
    ]
    if rng.random() < 0.5:
        container = [
            cylinder(0.44 * width, 0.15, 0.006, 40).painted(CLEAR),
            cylinder(0.46 * width, 0.03, 0.008, 40).moved(z=0.135).painted(DARK),
        ]
        parts += [part.turned("y", 78).moved(-0.06 * length, 0.46 * width, top - 0.052) for part in container]
    else:
        parts += [
            box(0.006, 0.7 * width, 0.010, 0.002)
            .moved(0.12 * length + 0.013 * k, 0.35 * width, top - 0.052 - 0.003 * k)
            .painted(DARK)
            for k in range(5)
        ]
    return parts


def _pipe(length: float, turn_deg: float, paint: tuple[int, int, int]) -> list[Mesh]:
    """The pipe upright on its nozzle, `turn_deg` about z, with a collar, and at its top the bent grip for the hose."""
    bend = np.linspace(0, 1, 15)[:, None]
    a, b, c = np.array([(0, 0, length - 0.02), (0.0, 0, length + 0.055), (0.09, 0, length + 0.010)])
    grip = (1 - bend) ** 2 * a + 2 * bend * (1 - bend) * b + bend**2 * c
    sole = prism(rounded_rectangle(0.24, 0.075, 0.020, 4), 0.026, 0.006).painted(BLACK)
    hood = prism(rounded_rectangle(0.13, 0.050, 0.020, 4), 0.024, 0.008).moved(z=0.020).painted(paint)
    return [
        *(part.turned("z", turn_deg) for part in (sole, hood)),
        cylinder(0.021, 0.050, 0.004, 20).moved(z=0.035).painted(DARK),
        cylinder(0.0165, length - 0.05, 0, 24).moved(z=0.04).painted(SILVER),
        cylinder(0.0215, 0.055, 0.005, 20).moved(z=0.46 * length).painted(BLACK),
        box(0.012, 0.018, 0.030, 0.003).moved(0.020, 0, 0.47 * length).painted(paint),
        sweep(circle(0.0195, 16), grip, up=(0, 1, 0)).painted(BLACK),
    ]


def _hose(start: np.ndarray, end: np.ndarray, sag: float) -> list[Mesh]:
    """The ribbed hose from the socket to the grip, hanging out to one side, a sleeve at either end."""
    knots = [
        start,
        start + np.array([0.045, 0.1 * sag, 0.055]),
        (0.06, 0.9 * sag, 0.66 * end[2]),
        end + np.array([0.075, 0.8 * sag, 0.01]),
        end + np.array([0.03, 0.1 * sag, -0.008]),
        end,
    ]
    steps = np.cumsum([0.0, *np.linalg.norm(np.diff(knots, axis=0), axis=1)])
    path = CubicSpline(steps, knots)(np.linspace(0, steps[-1], 100))
    ribs = 1 + 0.10 * (np.arange(100) // 2 % 2)
    sleeve = sweep(circle(0.022, 16), path[:8], up=(0, 1, 0)).painted(BLACK)
    cuff = sweep(circle(0.021, 16), path[-7:], up=(0, 1, 0)).painted(DARK)
    return [sweep(circle(0.0155, 10), path, up=(0, 1, 0), scales=ribs[:, None]).painted(GREY), sleeve, cuff]
