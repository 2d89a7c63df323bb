"""Handles of cups: a bow in the plane x = 0 towards +y, both ends sunk into a vessel's wall."""

from dataclasses import dataclass

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.solids import circle, rounded_rectangle, sweep


@dataclass(frozen=True)
class Bow:
    """A family of handles, the least and the largest of every measure."""

    lower: tuple[float, float]  # where it meets the wall, shares of the height
    upper: tuple[float, float]
    reach: tuple[float, float]  # out from the wall [m]
    squareness: tuple[float, float]  # 1: half an ellipse, 4: almost a rectangle
    lean: tuple[float, float] = (-0.05, 0.10)  # how much further the upper half reaches than the middle, as a share


C = Bow((0.14, 0.30), (0.68, 0.90), (0.024, 0.038), (1.0, 1.3))
D = Bow((0.12, 0.28), (0.72, 0.90), (0.024, 0.040), (1.8, 3.0))
EAR = Bow((0.14, 0.32), (0.76, 0.92), (0.026, 0.042), (1.0, 1.6), (0.35, 0.75))
ANGULAR = Bow((0.12, 0.35), (0.74, 0.92), (0.026, 0.042), (2.6, 4.0), (0.15, 0.70))
LOOP = Bow((0.08, 0.18), (0.80, 0.93), (0.036, 0.050), (1.1, 2.2))  # for the whole hand
HIGH = Bow((0.34, 0.48), (0.82, 0.93), (0.020, 0.034), (1.0, 2.0), (-0.05, 0.50))
LOW = Bow((0.08, 0.16), (0.50, 0.66), (0.022, 0.034), (1.0, 2.0))
BOWS = (C, D, EAR, ANGULAR, LOOP, HIGH, LOW)


def handle(rng: np.random.Generator, bow: Bow, wall: np.ndarray, depth: float, size: float = 1.0) -> Mesh:
    """A handle of a family on a wall (P, 2) of radius and height [m], its ends `depth` deep in it.

    `size` scales the reach and the cross-section: 1 suits a mug of 9 cm.
    """
    height = wall[-1, 1]
    lower, upper, reach, squareness, lean = rng.uniform(
        *np.transpose([bow.lower, bow.upper, bow.reach, bow.squareness, bow.lean])
    )
    lower, upper = lower * height, upper * height
    angles = np.linspace(-np.pi / 2, np.pi / 2, 29)
    out = np.cos(angles) ** (1 / squareness)  # a superellipse
    along = np.sign(angles) * np.abs(np.sin(angles)) ** (1 / squareness)
    out *= 1 + lean * along
    out /= out.max()
    z = lower + (upper - lower) * (1 + along) / 2
    rising = wall[np.argsort(wall[:, 1], kind="stable")]
    surface = np.interp(z, rising[:, 1], rising[:, 0])
    chord = surface[0] + (surface[-1] - surface[0]) * (z - lower) / (upper - lower)
    y = chord - depth + (size * reach + depth + np.max(surface - chord)) * out
    z += rng.uniform(0, 0.10) * (upper - lower) * out * (1 + along) / 2
    flare = 1 + rng.uniform(0, 0.35) * np.abs(along[:, None]) ** 6  # thicker where it meets the wall
    return sweep(size * section(rng), np.column_stack([0 * y, y, z]), up=(1, 0, 0), scales=flare)


def section(rng: np.random.Generator) -> np.ndarray:
    """A handle's cross-section (N, 2) [m], its width along the second axis: a flat strap, a round rod, or between."""
    kind = rng.integers(3)
    if kind == 0:
        return rounded_rectangle(rng.uniform(0.0045, 0.0065), rng.uniform(0.012, 0.020), radius=0.002, segments=3)
    if kind == 1:
        return circle(rng.uniform(0.0040, 0.0068), 16) * (1, rng.uniform(0.9, 1.2))
    return rounded_rectangle(rng.uniform(0.007, 0.011), rng.uniform(0.009, 0.014), radius=0.003, segments=3)
