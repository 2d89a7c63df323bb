"""The chopper (thesis 5.2): a model helicopter with cockpit, boom, skids and two rotors; no side is like another."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.solids import (
    box,
    circle,
    cylinder,
    ellipsoid,
    loft,
    prism,
    rounded_rectangle,
    sweep,
)

BLACK, GREY, SILVER = (58, 60, 66), (128, 132, 140), (200, 204, 208)
GLASS, WHITE = (54, 74, 100), (232, 232, 226)
RED, BLUE, YELLOW, GREEN, ORANGE = (190, 44, 44), (44, 92, 160), (232, 190, 52), (84, 104, 74), (222, 112, 40)
PAINTS = (RED, BLUE, YELLOW, GREEN, ORANGE, WHITE, GREY)
AXLE = 0.115  # height of the fuselage's axis above the floor [m]


def build(rng: np.random.Generator) -> Mesh:
    """A helicopter 40 to 50 cm long; instances differ in cabin, boom, equipment, rotors, their angles and in paint."""
    frame = _Frame(*rng.uniform((0.155, 0.043, 0.046, 0.245, 0.014, 0.0), (0.180, 0.050, 0.055, 0.270, 0.030, 0.4)))
    paint, trim = (PAINTS[i] for i in rng.permutation(len(PAINTS))[:2])
    blades, turn, span = int(rng.integers(2, 6)), rng.uniform(0, 360), rng.uniform(0.165, 0.200)
    parts = [
        _fuselage(frame, paint, trim),
        *(part.moved(z=0.75 * frame.height) for part in _engine(frame, trim)),
        *(part.turned("z", turn).moved(-0.02, 0, frame.height) for part in _rotor(blades, span, paint)),
        *(part.moved(-frame.tail, 0, frame.rise) for part in _tail(rng, trim)),
        *_skids(frame),
        *_equipment(frame, rng.choice([-1, 1]), bool(rng.integers(2))),
    ]
    return merge(part.moved(z=AXLE) for part in parts)


@dataclass(frozen=True)
class _Frame:
    """Sizes of the fuselage [m]."""

    cabin: float  # length
    width: float  # half
    height: float  # half
    tail: float  # from the cabin's centre to the end of the boom
    rise: float  # of the boom's end above the cabin's axis
    nose: float  # from pointed, 0, to blunt, 1


def _fuselage(frame: _Frame, paint: tuple[int, int, int], trim: tuple[int, int, int]) -> Mesh:
    """The cabin and the boom in one skin: windscreen and side windows, a stripe along the boom."""
    cabin, width, height, rise, nose = frame.cabin, frame.width, frame.height, frame.rise, frame.nose
    stations = np.array(
        [  # x, half the width, upper and lower edge
            (-frame.tail - 0.01, 0.008, rise + 0.010, rise - 0.010),
            (-frame.tail + 0.10, 0.011, rise + 0.013, rise - 0.014),
            (-0.50 * cabin, 0.018, 0.60 * height, -0.05 * height),
            (-0.25 * cabin, 0.80 * width, 0.92 * height, -0.75 * height),
            (0, width, height, -height),
            (0.25 * cabin, (0.86 + 0.1 * nose) * width, (0.72 + 0.2 * nose) * height, -0.98 * height),
            (0.42 * cabin, (0.55 + 0.2 * nose) * width, (0.10 + 0.4 * nose) * height, -0.75 * height),
            (0.50 * cabin, 0.06 * width, -0.28 * height, -0.40 * height),
        ]
    )
    boom, body = stations[0, 0], stations[2, 0]
    front = cabin * (0.5 - np.array([0.05, 0.025, 0.01, 0.0]))
    x = np.concatenate([np.linspace(boom, body, 13, endpoint=False), np.linspace(body, 0.42 * cabin, 30), front])
    wide, above, below = PchipInterpolator(stations[:, 0], stations[:, 1:])(x).T
    angle = 2 * np.pi * np.arange(40) / 40
    outline = np.column_stack([np.cos(angle), np.sin(angle)])
    outline = np.sign(outline) * np.abs(outline) ** 0.85
    half, middle = (above - below) / 2, (above + below) / 2
    y = wide[:, None] * outline[:, 0]
    z = middle[:, None] + half[:, None] * outline[:, 1]
    mesh = loft(np.stack([np.broadcast_to(x[:, None], y.shape), y, z], axis=2))
    x, y, z = mesh.vertices.T
    colors = np.tile(np.array(paint), (len(x), 1))
    colors[(x < -0.35 * cabin) & (np.abs(z - rise) < 0.006)] = trim
    colors[z < -0.55 * height] = trim
    screen = (x > 0.17 * cabin) & (z > -0.25 * height) & (np.abs(y) > 0.004)
    window = (np.abs(x - 0.02 * cabin) < 0.11 * cabin) & (np.abs(z - 0.22 * height) < 0.38 * height)
    colors[screen | window] = GLASS
    return Mesh(mesh.vertices, mesh.triangles, colors.astype(np.uint8))


def _engine(frame: _Frame, trim: tuple[int, int, int]) -> list[Mesh]:
    """The cowling above the cabin, an exhaust at its right and an intake at its left."""
    exhaust = np.array(
        [(-0.02, -0.012, 0.008), (-0.045, -0.022, 0.012), (-0.062, -0.036, 0.016), (-0.070, -0.048, 0.017)]
    )
    return [
        ellipsoid(0.36 * frame.cabin, 0.52 * frame.width, 0.026, 24).moved(-0.16 * frame.cabin).painted(trim),
        sweep(circle(0.0085, 16), exhaust).painted(GREY),
        cylinder(0.010, 0.020, 0.002, 20).turned("y", 90).moved(-0.012, 0.40 * frame.width, 0.014).painted(BLACK),
    ]


def _rotor(blades: int, span: float, paint: tuple[int, int, int]) -> list[Mesh]:
    """Mast, hub and the blades: pitched, drooping, with a painted tip."""
    hub = 0.034
    share = np.linspace(0, 1, 15)
    chord = np.interp(share, [0, 0.08, 0.16, 0.97, 1], [0.35, 0.4, 1, 1, 0.7])
    path = np.column_stack([0.012 + share * (span - 0.012), 0.004 * share, hub + 0.004 - 0.010 * share**2])
    profile = rounded_rectangle(0.023, 0.0036, 0.0016, 2)
    blade = sweep(profile, path, up=(0, -0.14, 1), scales=np.column_stack([chord, 1 + 0 * chord]))
    x = blade.vertices[:, 0]
    colors = np.where((np.abs(x - 0.88 * span) < 0.07 * span)[:, None], np.array(paint), np.array(BLACK))
    blade = Mesh(blade.vertices, blade.triangles, colors.astype(np.uint8))
    grip = box(0.030, 0.010, 0.008, 0.001).moved(0.016, 0, hub).painted(SILVER)
    return [
        cylinder(0.0055, hub + 0.004, 0, 16).painted(GREY),
        cylinder(0.011, 0.012, 0.003, 20).moved(z=hub - 0.002).painted(BLACK),
        cylinder(0.013, 0.003, 0, 20).moved(z=0.018).painted(SILVER),
        *(part.turned("z", 360 * k / blades) for k in range(blades) for part in [blade, grip]),
    ]


def _tail(rng: np.random.Generator, trim: tuple[int, int, int]) -> list[Mesh]:
    """The fin, swept and slightly to one side, the stabiliser, a skid below, and the tail rotor at the left."""
    height, sweep_back, blades = rng.uniform(0.050, 0.070), rng.uniform(0.020, 0.040), int(rng.integers(2, 5))
    fin = _plate([(0.045, 0), (-0.010, 0), (-0.010 - sweep_back, height), (0.012 - sweep_back, height)], 0.006)
    lower = _plate([(0.030, 0), (-0.008, 0), (-0.022, -0.030), (-0.004, -0.030)], 0.005)
    wing = box(0.032, 0.110, 0.004, 0.001).moved(0.075, 0.004, 0)
    blade = prism(rounded_rectangle(0.036, 0.009, 0.003, 3), 0.002).moved(0.020)
    turn = rng.uniform(0, 360)
    rotor = [
        cylinder(0.005, 0.016, 0.001, 14),
        *(blade.turned("x", 12).turned("z", turn + 360 * k / blades).moved(z=0.011) for k in range(blades)),
    ]
    return [
        fin.moved(y=0.001).painted(trim),
        lower.painted(trim),
        wing.painted(trim),
        *(part.turned("x", -90).moved(-0.012, 0.004, 0.012).painted(BLACK) for part in rotor),
    ]


def _plate(corners: list[tuple[float, float]], thickness: float) -> Mesh:
    """An upright plate (corners x, z) about the plane y = 0."""
    x, z = np.array(corners).T
    return loft(np.stack([np.column_stack([x, np.full(len(x), y), z]) for y in (-thickness / 2, thickness / 2)]))


def _skids(frame: _Frame) -> list[Mesh]:
    """Two runners with upturned noses on bowed struts, a step at the left."""
    track, ground = 1.35 * frame.width, 0.004 - AXLE
    x = np.array([-0.48, -0.3, 0.0, 0.3, 0.46, 0.55, 0.60]) * frame.cabin
    runner = np.column_stack([x, 0 * x, ground + np.array([0, 0, 0, 0, 0.003, 0.014, 0.028])])
    bow = np.linspace(-1, 1, 13)
    strut = np.column_stack(
        [0 * bow, track * bow, ground + (AXLE - 0.85 * frame.height) * np.sqrt(1.0001 - np.abs(bow) ** 2.5)]
    )
    return [
        *(sweep(circle(0.0042, 12), runner).moved(y=side * track).painted(SILVER) for side in (-1, 1)),
        *(sweep(circle(0.0036, 10), strut, up=(1, 0, 0)).moved(k * frame.cabin).painted(GREY) for k in (-0.24, 0.22)),
        box(0.055, 0.016, 0.004).moved(0.0, 0.9 * track, ground + 0.030).painted(BLACK),
    ]


def _equipment(frame: _Frame, side: int, hoist: bool) -> list[Mesh]:
    """A hoist or a pod at one side, a tank at the other, a searchlight and a whip antenna under the nose."""
    antenna = np.array([(0.0, 0, 0), (-0.006, -0.002, -0.02), (-0.018, -0.004, -0.038)])
    cabin, wall, height = frame.cabin, side * frame.width, frame.height
    if hoist:
        beside = [
            box(0.048, 0.020, 0.014, 0.002).moved(0.02, 1.08 * wall, 0.62 * height).painted(GREY),
            cylinder(0.009, 0.024, 0.002, 16).moved(0.030, 1.20 * wall, 0.30 * height).painted(SILVER),
        ]
    else:
        beside = [ellipsoid(0.075, 0.014, 0.016, 20).moved(0.01, 1.50 * wall, 0.022 - AXLE).painted(ORANGE)]
    return [
        *beside,
        ellipsoid(0.040, 0.013, 0.014, 20).moved(-0.12 * cabin, -wall, -0.35 * height).painted(SILVER),
        cylinder(0.012, 0.014, 0.002, 20).turned("y", 110).moved(0.34 * cabin, 0.012, -height).painted(SILVER),
        sweep(circle(0.0016, 8), antenna).moved(0.10 * cabin, -0.012, -0.95 * height).painted(BLACK),
    ]
