"""The bin (thesis 5.2): a pedal bin, round but for the pedal in front, the hinge and the handle behind."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.solids import box, circle, cylinder, revolve, sweep

BLACK, STEEL = (58, 60, 66), (184, 188, 192)
PAINTS = ((70, 118, 92), (186, 190, 192), (158, 60, 48), (62, 84, 124), (212, 204, 186))


def build(rng: np.random.Generator) -> Mesh:
    """A pedal bin 32 to 40 cm high; instances differ in proportions, paint and the dome of the lid."""
    radius, taper, height, dome = rng.uniform((0.105, 0.82, 0.28, 0.035), (0.125, 0.98, 0.33, 0.06))
    foot = taper * radius
    paint = PAINTS[rng.integers(len(PAINTS))]
    body = revolve(np.array([(0, 0.012), (foot, 0.012), (radius, height), (0, height)]), 64)
    angles = np.linspace(0, np.pi / 2, 10)[:-1]
    curve = np.column_stack([(radius + 0.004) * np.cos(angles), dome * np.sin(angles)])
    lid = revolve(np.array([(0, 0), *curve, (0, dome)]), 64)
    return merge(
        [
            cylinder(foot + 0.004, 0.016, 0.003, 64).painted(BLACK),
            body.painted(paint),
            cylinder(radius + 0.004, 0.012, 0.002, 64).moved(z=height - 0.010).painted(BLACK),
            lid.moved(z=height + 0.001).painted(STEEL),
            *_pedal(foot),
            box(0.030, 0.055, 0.034, 0.004).moved(-radius - 0.008, 0, height - 0.020).painted(BLACK),
            _handle(foot + (radius - foot) * 0.8).moved(z=0.8 * height).painted(BLACK),
        ]
    )


def _pedal(foot: float) -> list[Mesh]:
    """A lever out of the base and the plate to step on."""
    return [
        box(0.060, 0.012, 0.008, 0.002).moved(foot + 0.012, 0, 0.020).painted(STEEL),
        box(0.030, 0.060, 0.010, 0.003).moved(foot + 0.050, 0, 0.019).painted(BLACK),
    ]


def _handle(radius: float) -> Mesh:
    """A bow that hangs out from the rear of a wall of the given radius."""
    half = 0.05
    angles = np.linspace(0, np.pi, 19)
    wall = -np.sqrt(radius**2 - half**2) + 0.004
    bow = np.column_stack([wall - 0.045 * np.sin(angles), half * np.cos(angles), -0.020 * np.sin(angles)])
    return sweep(circle(0.005, 10), bow)
