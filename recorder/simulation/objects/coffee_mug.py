"""Coffee mugs and cups, from espresso to latte: hollow, 5.5 to 13 cm high, the handle at +y, where the right hand of
who stands before it finds it."""

import numpy as np

from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation.objects.handle import ANGULAR, BOWS, EAR, HIGH, LOOP, Bow, C, D, handle
from orbitscan.recorder.simulation.objects.solids import revolve, rounded_rectangle, sweep
from orbitscan.recorder.simulation.objects.vessel import coupe, hollow, silhouette, superellipse

WHITE = (238, 236, 228)
RED, BLUE, YELLOW, GREEN = (196, 70, 54), (52, 98, 158), (230, 186, 60), (74, 124, 84)
SLATE, PURPLE, APRICOT = (84, 88, 98), (128, 84, 132), (214, 132, 90)
GLAZES = (WHITE, RED, BLUE, YELLOW, GREEN, SLATE, PURPLE, APRICOT)


def everyday(rng: np.random.Generator) -> Mesh:
    """A mug; instances differ in size, in the wall (straight, tapered, bellied), in handle and glaze."""
    radius, height, thickness = rng.uniform((0.036, 0.080, 0.0030), (0.046, 0.105, 0.0045))
    taper, belly = rng.uniform((0.80, 0.0), (1.02, 0.10))
    glaze = GLAZES[rng.integers(len(GLAZES))]
    share = np.linspace(0, 1, 13)  # of the way up
    radii = radius * (taper + (1 - taper) * share + belly * np.sin(np.pi * share))
    wall = np.column_stack([radii, 0.003 + (height - 0.005) * share])
    return merge([_shell(wall, thickness, glaze), _handle(rng, wall, 0.6 * thickness).painted(glaze)])


def _shell(wall: np.ndarray, thickness: float, glaze: tuple[int, int, int]) -> Mesh:
    """The hollow body of an outer wall (P, 2) of radius and height: glazed outside, white inside."""
    (foot, _), (rim, top) = wall[[0, -1]]
    floor = 0.008
    inside = np.column_stack([wall[:, 0] - thickness, np.linspace(floor, top, len(wall))])
    lip = [(rim - share * thickness, top + 0.0016) for share in (0.3, 0.7)]
    shell = revolve(np.array([(0, 0), (foot - 0.003, 0), *wall, *lip, *inside[::-1], (0, floor)]), 56)
    x, y, z = shell.vertices.T
    glazed = (z < floor / 2) | (np.hypot(x, y) > np.interp(z, wall[:, 1], wall[:, 0] - thickness / 2))
    colors = np.where(glazed[:, None], np.array(glaze), np.array(WHITE)).astype(np.uint8)
    return Mesh(shell.vertices, shell.triangles, colors)


def _handle(rng: np.random.Generator, wall: np.ndarray, depth: float) -> Mesh:
    """A handle from round to square, both ends sunk into the wall."""
    height = wall[-1, 1]
    lower, upper = rng.uniform((0.18, 0.78), (0.30, 0.88)) * height
    reach, squareness = rng.uniform((0.024, 1.0), (0.034, 2.0))
    angles = np.linspace(-np.pi / 2, np.pi / 2, 25)
    out = np.cos(angles) ** (1 / squareness)  # a superellipse
    along = np.sign(angles) * np.abs(np.sin(angles)) ** (1 / squareness)
    z = (lower + upper) / 2 + (upper - lower) / 2 * along
    y = np.interp(z, wall[:, 1], wall[:, 0]) - depth + reach * out
    thick, wide = rng.uniform((0.006, 0.009), (0.009, 0.014))
    outline = rounded_rectangle(thick, wide, radius=0.0025, segments=3)
    return sweep(outline, np.column_stack([0 * y, y, z]), up=(1, 0, 0))


def straight(rng: np.random.Generator) -> Mesh:
    """A cylinder, from narrow to wider than high."""
    height = rng.uniform(0.078, 0.105)
    radius = height * rng.uniform(0.36, 0.56)
    return _mug(rng, silhouette(height, (radius, radius), rng.uniform(0.002, 0.012)), BOWS)


def latte(rng: np.random.Generator) -> Mesh:
    """A tall cone that opens upwards."""
    height, foot = rng.uniform((0.100, 0.58), (0.130, 0.78))
    radius = height * rng.uniform(0.34, 0.42)
    bulge = rng.uniform(0.0, 0.06)
    return _mug(rng, silhouette(height, _times(radius, foot, (foot + 1) / 2 + bulge, 1)), (C, D, EAR, ANGULAR, LOOP))


def wide_based(rng: np.random.Generator) -> Mesh:
    """A cone that narrows upwards, some with a lip turned out."""
    height, rim, lip = rng.uniform((0.080, 0.70, 0.0), (0.125, 0.90, 0.06))
    radius = min(height * rng.uniform(0.42, 0.56), 0.054)
    wall = silhouette(height, _times(radius, 1, (1 + rim) / 2, rim, rim + lip), 0.006)
    return _mug(rng, wall, (C, D, ANGULAR, LOOP))


def bellied(rng: np.random.Generator) -> Mesh:
    """A fat mug: widest at or below the middle, the rim narrower."""
    height, radius = rng.uniform((0.076, 0.046), (0.105, 0.058))
    foot, belly, neck, rim = rng.uniform((0.62, 0.96, 0.82, 0.78), (0.82, 1.00, 0.95, 0.94))
    return _mug(rng, silhouette(height, _times(radius, foot, belly, 1, neck, rim), 0.005), (C, D, EAR, LOOP))


def barrel(rng: np.random.Generator) -> Mesh:
    """Widest in the middle, or narrowest there: foot and rim are alike."""
    height, end, middle = rng.uniform((0.078, 0.84, 0.86), (0.112, 0.95, 0.95))
    radius = height * rng.uniform(0.38, 0.54)
    shape = (end, 1, end) if rng.random() < 0.7 else (1, middle, 1)
    return _mug(rng, silhouette(height, _times(radius, *shape)), BOWS)


def espresso(rng: np.random.Generator) -> Mesh:
    """A small cup 5.5 to 7 cm high with a handle for two fingers."""
    height, foot = rng.uniform((0.055, 0.64), (0.070, 1.0))
    radius = height * rng.uniform(0.46, 0.58)
    middle = foot + (1 - foot) * rng.uniform(0.5, 0.9)
    return _mug(rng, silhouette(height, _times(radius, foot, middle, 1)), (C, D, EAR, ANGULAR, HIGH))


def tea_cup(rng: np.random.Generator) -> Mesh:
    """Almost a bowl: low, wide and round towards a small foot."""
    radius, share, exponent, flare = rng.uniform((0.041, 1.20, 0.7, 0.0), (0.054, 1.55, 1.4, 0.005))
    height, foot, lift = radius * share, radius * rng.uniform(0.45, 0.66), rng.uniform(0.003, 0.008)
    wall = coupe(foot, radius, lift, height, exponent, flare * rng.integers(2))
    base = [(0.90 * foot, 0), (foot, 0.4 * lift)]
    return _mug(rng, np.concatenate([base, wall]), (C, EAR, ANGULAR, HIGH), floor=lift + 0.004)


def travel(rng: np.random.Generator) -> Mesh:
    """A tall one for the road: the foot, narrower than the body, fits a cup holder; some with a step, some a cone."""
    height, foot, rise = rng.uniform((0.112, 0.66, 0.0), (0.130, 0.86, 0.12))
    radius = height * rng.uniform(0.32, 0.38)
    shape = (foot, foot + rise / 3, 1 - rise, 1, 1) if rng.random() < 0.5 else (foot, (1 + foot) / 2, 1)
    return _mug(rng, silhouette(height, _times(radius, *shape)), (D, ANGULAR, LOOP, C))


def square(rng: np.random.Generator) -> Mesh:
    """A section between a circle and a square, the foot rounder or not."""
    height, exponent, foot = rng.uniform((0.080, 2.8, 0.80), (0.105, 6.0, 1.0))
    radius = height * rng.uniform(0.38, 0.48)
    outline = superellipse(exponent, segments=72)
    return _mug(rng, silhouette(height, _times(radius, foot, 1)), (C, D, EAR, ANGULAR), outline=outline)


def tulip(rng: np.random.Generator) -> Mesh:
    """A round belly on a foot, drawn in above it and opening to the rim."""
    height, foot, belly, waist = rng.uniform((0.085, 0.55, 0.86, 0.80), (0.118, 0.75, 1.0, 0.92))
    radius = height * rng.uniform(0.40, 0.48)
    return _mug(rng, silhouette(height, _times(radius, foot, belly, waist, 1), 0.003), (C, D, EAR, HIGH, LOOP))


def enamel(rng: np.random.Generator) -> Mesh:
    """A camper's mug: a thin straight wall, a rolled rim, an ear of flat metal."""
    height = rng.uniform(0.070, 0.090)
    radius = height * rng.uniform(0.46, 0.60)
    wall = silhouette(height, _times(radius, rng.uniform(0.90, 1.0), 1), 0.005)
    rolled = np.array([(0.0025, 0.0005), (0.003, 0.002), (0.0015, 0.0035)])
    return _mug(rng, np.concatenate([wall, wall[-1] + rolled]), (EAR, D, C), thickness=0.0015)


STYLES = (everyday, straight, bellied, latte, tea_cup, barrel, espresso, wide_based, square, tulip, travel, enamel)


def _times(radius: float, *shares: float) -> tuple[float, ...]:
    return tuple(radius * share for share in shares)


def _mug(
    rng: np.random.Generator,
    wall: np.ndarray,
    bows: tuple[Bow, ...],
    thickness: float | None = None,
    floor: float | None = None,
    outline: np.ndarray | None = None,
) -> Mesh:
    """A hollow mug of an outer wall (P, 2) with one of the handles, in its glazes."""
    radius, height = wall.max(axis=0)
    outside, within = (GLAZES[i] for i in rng.permutation(len(GLAZES))[:2])
    within = WHITE if rng.random() < 0.6 and outside != WHITE else within
    bow = bows[rng.integers(len(bows))]
    thickness = thickness or rng.uniform(0.0022, 0.0058) * min(1, radius / 0.042)
    floor = floor or wall[0, 1] + rng.uniform(0.004, 0.010) * min(1, height / 0.09)
    body = hollow(wall, thickness, floor, (outside, within), outline)
    size = np.clip(height / 0.090, 0.65, 1.1)
    return merge([body, handle(rng, bow, wall, 0.6 * thickness, size).painted(outside)])
