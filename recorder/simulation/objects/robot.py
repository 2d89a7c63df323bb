"""The pioneer robot (thesis 5.2): two driven wheels and a caster, a row of sonars, laser scanner, arm and camera mast.

Shapes of every size, and no side of it repeats another.
"""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
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

BLACK, DARK, GREY, SILVER = (58, 60, 66), (92, 96, 104), (140, 144, 150), (200, 204, 208)
RED, BLUE, ORANGE, YELLOW = (186, 38, 44), (48, 100, 172), (230, 126, 40), (236, 200, 48)
GOLD, LENS = (196, 160, 84), (34, 42, 78)
CLEARANCE = 0.045  # of the hull above the floor [m]
CORNER = 0.42  # radius of the hull's corners, in its width
SONARS_DEG = (-90, -50, -30, -10, 10, 30, 50, 90)  # the bearings of the Pioneer's front row


def build(rng: np.random.Generator) -> Mesh:
    """A robot about 35 cm long and 38 cm high; instances differ in every proportion and in how the arm is held."""
    length, width, height = rng.uniform((0.30, 0.20, 0.095), (0.34, 0.23, 0.115))
    deck = CLEARANCE + height
    wheel = _wheel(rng.uniform(0.072, 0.082), 0.036, width / 2 + 0.004)
    laser_scanner = _laser_scanner(rng.uniform(0.085, 0.105))
    camera_mast = _camera_mast(rng.uniform(0.19, 0.23))
    arm = _arm(*rng.uniform((25, 95, 20), (40, 115, 40)))
    parts = [
        *_hull(length, width, height),
        *_sonars(length, width, deck - 0.030),
        *wheel,
        *(part.turned("z", 180).moved(0.04) for part in wheel),
        *(part.moved(-0.42 * length) for part in _caster()),
        *(part.moved(0.25 * length, 0.0, deck) for part in laser_scanner),
        *(part.moved(-0.30 * length, 0.26 * width, deck) for part in camera_mast),
        *(part.moved(-0.10 * length, -0.24 * width, deck) for part in arm),
        *(part.moved(-0.40 * length, -0.22 * width, deck) for part in _emergency_stop()),
    ]
    return merge(parts)


def _hull(length: float, width: float, height: float) -> list[Mesh]:
    """The hull with its deck, the bumper before it, and vents at its rear."""
    outline = rounded_rectangle(length, width, CORNER * width)
    bearings = np.radians(np.linspace(-70, 70, 21))
    arc = 0.56 * width * np.column_stack([np.cos(bearings), np.sin(bearings), 0 * bearings])
    bumper = sweep(rounded_rectangle(0.014, 0.022, 0.005, 2), arc)
    brackets = [box(0.05, 0.012, 0.010).moved(length / 2, side * 0.2 * width, 0.007) for side in (-1, 1)]
    slots = [box(0.006, 0.3 * width, 0.005).moved(-length / 2, 0, 0.62 * height - 0.011 * i) for i in range(4)]
    return [
        prism(outline, height, 0.008).moved(z=CLEARANCE).painted(RED),
        prism(1.03 * outline, 0.008, 0.002).moved(z=CLEARANCE + height - 0.002).painted(DARK),
        bumper.moved(0.5 * length - 0.46 * width, 0, CLEARANCE + 0.012).painted(BLACK),
        *(part.moved(z=CLEARANCE).painted(BLACK) for part in [*brackets, *slots]),
    ]


def _sonars(length: float, width: float, z: float) -> list[Mesh]:
    """Transducers that look out of the front half of the hull, each along its surface's normal."""
    sonar = [cylinder(0.0165, 0.010, 0.002, 16).painted(BLACK), cylinder(0.0125, 0.012, 0, 16).painted(GOLD)]
    corner = CORNER * width
    parts = []
    for bearing in SONARS_DEG:
        x = length / 2 - corner + corner * np.cos(np.radians(bearing))
        y = np.sign(bearing) * (width / 2 - corner) + corner * np.sin(np.radians(bearing))
        parts += [part.moved(z=-0.004).turned("y", 90).turned("z", bearing).moved(x, y, z) for part in sonar]
    return parts


def _wheel(radius: float, thickness: float, y: float) -> list[Mesh]:
    """The left wheel, its inner side at y: a tyre with lugs, a dished rim, five spokes and a hub."""
    tread = [(0.62, 0), (0.66, -0.10), (0.9, -0.06), (1, 0.14), (1, 0.86), (0.9, 1.06), (0.66, 1.10), (0.62, 0.72)]
    profile = np.array([(0, 0), *tread, (0, 0.72)]) * (radius, thickness)
    lug = box(0.005, 0.010, 0.92 * thickness).moved(radius, 0, 0.04 * thickness)
    spoke = box(0.50 * radius, 0.013, 0.012, 0.002).moved(0.34 * radius, 0, 0.68 * thickness)
    parts = [
        revolve(profile, 40).painted(BLACK),
        cylinder(0.018, 0.9 * thickness + 0.004, 0.003, 20).painted(SILVER),
        *(spoke.turned("z", 72 * i).painted(GREY) for i in range(5)),
        *(lug.turned("z", 18 * i).painted(BLACK) for i in range(20)),
    ]
    return [part.turned("x", -90).moved(0.02, y, radius) for part in parts]


def _caster() -> list[Mesh]:
    """The swivelling wheel under the rear."""
    roller = cylinder(0.024, 0.018, 0.003, 24).moved(z=-0.009).turned("x", 90).moved(-0.012, 0, 0.024)
    forks = [box(0.03, 0.004, 0.036).moved(-0.006, side * 0.013, 0.018) for side in (-1, 1)]
    return [roller.painted(BLACK), *(fork.painted(SILVER) for fork in forks)]


def _laser_scanner(height: float) -> list[Mesh]:
    """A housing with the scanning window between base and head, a plug behind."""
    return [
        prism(rounded_rectangle(0.085, 0.095, 0.012, 3), 0.45 * height, 0.004).painted(BLUE),
        cylinder(0.036, 0.30 * height, 0, 36).moved(0.004, 0, 0.42 * height).painted(LENS),
        prism(rounded_rectangle(0.085, 0.09, 0.038, 6), 0.32 * height, 0.006)
        .moved(0.002, 0, 0.68 * height)
        .painted(BLUE),
        box(0.012, 0.05, 0.012).moved(-0.046, 0, 0.1 * height).painted(BLACK),
    ]


def _camera_mast(height: float) -> list[Mesh]:
    """A mast with a stereo camera that looks forward and down, and an antenna behind it."""
    eye = [cylinder(0.014, 0.012, 0.002, 20).painted(BLACK), cylinder(0.010, 0.013, 0, 20).painted(LENS)]
    camera = [
        box(0.034, 0.12, 0.036, 0.005).painted(SILVER),
        *(part.turned("y", 90).moved(0.014, side * 0.038, 0.018) for side in (-1, 1) for part in eye),
    ]
    antenna = np.array([(-0.02, 0.0, 0.0), (-0.03, 0.01, 0.5 * height), (-0.045, 0.02, 0.9 * height)])
    return [
        box(0.05, 0.05, 0.012, 0.003).painted(BLACK),
        cylinder(0.011, height, 0, 24).painted(GREY),
        cylinder(0.017, 0.022, 0.003, 24).moved(z=height - 0.02).painted(BLACK),
        *(part.turned("y", 15).turned("z", -12).moved(0.002, 0, height) for part in camera),
        sweep(circle(0.004, 10), antenna, (1, 0, 0)).painted(BLACK),
    ]


def _arm(shoulder_deg: float, elbow_deg: float, wrist_deg: float) -> list[Mesh]:
    """An arm of two links on a turntable; a joint's angle is that to the link before it, the first's to the upright."""
    upper, fore = 0.115, 0.105
    finger = box(0.014, 0.008, 0.042, 0.002)
    gripper = [
        box(0.028, 0.040, 0.014, 0.002).painted(DARK),
        *(finger.moved(0, side * 0.016, 0.012).painted(SILVER) for side in (-1, 1)),
    ]
    forearm = [
        _joint(0.017, 0.036),
        _link(fore, 0.012),
        *(part.turned("y", wrist_deg).moved(z=fore) for part in gripper),
    ]
    upper_arm = [
        _joint(0.022, 0.050),
        _link(upper, 0.015),
        *(part.turned("y", elbow_deg).moved(z=upper) for part in forearm),
    ]
    return [
        cylinder(0.038, 0.022, 0.004, 32).painted(BLACK),
        cylinder(0.030, 0.032, 0.004, 32).painted(ORANGE),
        *(part.turned("y", -shoulder_deg).turned("z", 8).moved(z=0.048) for part in upper_arm),
    ]


def _link(length: float, radius: float) -> Mesh:
    """A rod up the z axis that thins towards its end."""
    profile = np.array([(0, 0), (radius, 0), (radius, 0.5 * length), (0.75 * radius, length), (0, length)])
    return revolve(profile, 24).painted(ORANGE)


def _joint(radius: float, width: float) -> Mesh:
    """A motor about the origin whose axis lies along y."""
    return cylinder(radius, width, 0.003, 24).moved(z=-width / 2).turned("x", 90).painted(DARK)


def _emergency_stop() -> list[Mesh]:
    """A red mushroom button on a yellow box."""
    return [
        box(0.040, 0.036, 0.026, 0.003).painted(YELLOW),
        cylinder(0.009, 0.012, 0, 16).moved(z=0.024).painted(BLACK),
        ellipsoid(0.015, 0.015, 0.008, 16).moved(z=0.038).painted(RED),
    ]
