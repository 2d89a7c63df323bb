"""Bowls, from a dip to a salad bowl: hollow, 8.5 to 24 cm across; but for the last styles no turn about z is seen."""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.solids import revolve
from orbitscan.recorder.simulation.objects.vessel import (
    SEGMENTS,
    coupe,
    fluted,
    hollow,
    inward,
    polygon,
    silhouette,
    superellipse,
)

CLAY, WHITE = (176, 132, 100), (238, 236, 228)
RED, BLUE, TEAL, GREEN = (172, 62, 50), (48, 84, 146), (62, 138, 140), (104, 128, 82)
SAND, SLATE, MUSTARD = (206, 180, 144), (84, 88, 98), (212, 162, 58)
GLAZES = (WHITE, RED, BLUE, TEAL, GREEN, SAND, SLATE, MUSTARD)


def everyday(rng: np.random.Generator) -> Mesh:
    """A bowl; instances differ in size, in the wall (from bellied to a cone, with or without a flare) and in glazes."""
    radius, height, thickness = rng.uniform((0.060, 0.050, 0.0030), (0.088, 0.085, 0.0048))
    foot = radius * rng.uniform(0.40, 0.58)
    lift = rng.uniform(0.004, 0.010)
    outside = coupe(foot, radius, lift, height, rng.uniform(0.75, 1.6), rng.uniform(0, 0.006) * rng.integers(2))
    inside = inward(outside, thickness)
    inside[-1] = outside[-1] - (thickness, 0)
    lip = [(outside[-1, 0] - share * thickness, height + 0.25 * thickness) for share in (0.3, 0.7)]
    ring = [(0, 0.6 * lift), (foot - 0.010, 0.5 * lift), (foot - 0.007, 0), (foot - 0.001, 0), (foot, 0.4 * lift)]
    mesh = revolve(np.array([*ring, *outside, *lip, *inside[::-1], (0, inside[0, 1])]), SEGMENTS)
    return Mesh(mesh.vertices, mesh.triangles, _glaze(rng, mesh, len(ring), len(outside)))


def cereal(rng: np.random.Generator) -> Mesh:
    """A bowl with a rim to hold it by, flat or rising a little."""
    return _rimmed(rng, rng.uniform(0.060, 0.085), rng.uniform(0.30, 0.44), rng.uniform(0.10, 0.20))


def soup(rng: np.random.Generator) -> Mesh:
    """Wide and shallow, almost a plate, with a broad rim, a narrow one or none."""
    return _rimmed(rng, rng.uniform(0.085, 0.115), rng.uniform(0.22, 0.30), rng.uniform(0.0, 0.28))


def hemisphere(rng: np.random.Generator) -> Mesh:
    """Half a ball, or somewhat less, on a small foot."""
    radius, share, foot = rng.uniform((0.052, 0.42, 0.26), (0.082, 0.55, 0.42))
    return _bowl(rng, _footed(radius, share, foot, rng.uniform(0.004, 0.009), rng.uniform(0.92, 1.1)))


def conical(rng: np.random.Generator) -> Mesh:
    """A straight wall from a foot, narrow or broad, to the rim."""
    radius, share, foot = rng.uniform((0.055, 0.30, 0.30), (0.095, 0.50, 0.55))
    return _bowl(rng, _footed(radius, share, foot, rng.uniform(0.001, 0.007), rng.uniform(1.7, 2.2)))


def salad(rng: np.random.Generator) -> Mesh:
    """A large salad bowl, thick as wood or thin as glass."""
    radius, share, foot = rng.uniform((0.100, 0.32, 0.35), (0.120, 0.50, 0.60))
    wall = _footed(radius, share, foot, rng.uniform(0.001, 0.010), rng.uniform(0.8, 1.5))
    return _bowl(rng, wall, rng.uniform(0.003, 0.009))


def dip(rng: np.random.Generator) -> Mesh:
    """A small one for sauces: a bowl, or steep as a ramekin."""
    radius, share, foot = rng.uniform((0.043, 0.36, 0.45), (0.055, 0.58, 0.92))
    return _bowl(rng, _footed(radius, share, foot, 0.002, rng.uniform(0.6, 1.4)), rng.uniform(0.0025, 0.0045))


def mixing(rng: np.random.Generator) -> Mesh:
    """Deep, of steel or enamel: thin, a broad base, the rim rolled outwards."""
    radius, share, foot = rng.uniform((0.070, 0.42, 0.45), (0.110, 0.58, 0.70))
    wall = silhouette(2 * radius * share, (foot * radius, (0.25 * foot + 0.74) * radius, radius), 0.010)
    rolled = np.array([(0.003, -0.0005), (0.0045, 0.001), (0.004, 0.003), (0.002, 0.004)])
    return _bowl(rng, np.concatenate([wall, wall[-1] + rolled]), 0.0016)


def rice(rng: np.random.Generator) -> Mesh:
    """Deep and round on a high foot ring, the lip straight or turned out."""
    radius, share, foot = rng.uniform((0.054, 0.44, 0.36), (0.080, 0.58, 0.48))
    flare = rng.uniform(0.0, 0.09) * radius
    return _bowl(rng, _footed(radius, share, foot, rng.uniform(0.009, 0.015), rng.uniform(0.8, 1.2), flare))


def wavy(rng: np.random.Generator) -> Mesh:
    """Waves about the rim that fade towards the foot."""
    radius, share, foot = rng.uniform((0.060, 0.28, 0.40), (0.110, 0.48, 0.58))
    outline = fluted(int(rng.choice([6, 8, 12, 16])), rng.uniform(0.03, 0.09))
    return _bowl(rng, _footed(radius, share, foot, 0.004, rng.uniform(0.9, 1.8)), outline=outline)


def square(rng: np.random.Generator) -> Mesh:
    """A soft square at the rim, rounder at the foot."""
    radius, share, foot = rng.uniform((0.055, 0.30, 0.42), (0.090, 0.50, 0.62))
    outline = superellipse(rng.uniform(2.8, 5.0))
    return _bowl(rng, _footed(radius, share, foot, 0.003, rng.uniform(0.8, 1.6)), outline=outline)


def cornered(rng: np.random.Generator) -> Mesh:
    """Six, eight or twelve mild corners about the rim."""
    radius, share, foot = rng.uniform((0.055, 0.28, 0.40), (0.095, 0.48, 0.58))
    outline = polygon(int(rng.choice([6, 8, 12])))
    return _bowl(rng, _footed(radius, share, foot, 0.004, rng.uniform(1.0, 2.0)), outline=outline)


ROUND = (everyday, cereal, hemisphere, conical, soup, dip, salad, mixing, rice)  # surfaces of revolution
STYLES = (*ROUND, wavy, square, cornered)


def _footed(radius: float, share: float, foot: float, lift: float, exponent: float, flare: float = 0.0) -> np.ndarray:
    """An outer wall (P, 2) [m] on a foot `lift` high and `foot` of the radius wide, `share` of the width high."""
    wall = coupe(foot * radius, radius, lift, 2 * radius * share, exponent, flare)
    return np.concatenate([[(0.95 * foot * radius, 0), (foot * radius, 0.4 * lift)], wall])


def _rimmed(rng: np.random.Generator, radius: float, share: float, rim: float) -> Mesh:
    """A bowl with a rim `rim` of the radius broad, flat or rising by up to 20 degrees."""
    broad, foot, exponent = rim * radius, rng.uniform(0.45, 0.62), rng.uniform(0.6, 1.2)
    rise = broad * np.tan(np.radians(rng.uniform(0, 20)))
    inner = radius - broad
    wall = _footed(inner, (2 * radius * share - rise) / (2 * inner), foot, rng.uniform(0.003, 0.006), exponent)
    return _bowl(rng, np.concatenate([wall, wall[-1] + np.linspace(0.25, 1, 4)[:, None] * (broad, rise)]))


def _bowl(
    rng: np.random.Generator, wall: np.ndarray, thickness: float | None = None, outline: np.ndarray | None = None
) -> Mesh:
    """The hollow bowl of an outer wall (P, 2) [m] in two of the glazes; an outline is round at the foot."""
    thickness = thickness or rng.uniform(0.0028, 0.0055)
    outer, inner = (GLAZES[i] for i in rng.permutation(len(GLAZES))[:2])
    if outer != WHITE and rng.random() < 0.5:
        inner = WHITE
    floor = wall[2, 1] + thickness  # the third row ends the foot
    return hollow(wall, thickness, floor, (outer, inner), outline, foot_share=0.2)


def _glaze(rng: np.random.Generator, mesh: Mesh, foot: int, wall: int) -> np.ndarray:
    """The colour of every vertex: bare clay below, a glaze outside and one inside, sometimes a band under the rim."""
    outer, inner, band = (np.array(GLAZES[i], np.uint8) for i in rng.permutation(len(GLAZES))[:3])
    if rng.random() < 0.5:
        inner = np.array(WHITE, np.uint8)
    banded = rng.integers(3)  # rows of the wall
    bare = rng.integers(3)
    rows = [np.array(CLAY, np.uint8)] * (foot - 1 + bare) + [outer] * (wall - bare - banded) + [band] * banded
    rows += [inner] * (len(mesh.vertices) // SEGMENTS - len(rows))
    return np.concatenate([np.repeat(rows, SEGMENTS, axis=0), [CLAY, inner]]).astype(np.uint8)
