"""Coffee mugs: hollow, 8 to 10.5 cm high, the handle at +y, where the right hand of who stands before it finds it."""

import numpy as np

from recorder.objects.mesh import Mesh, merge
from recorder.objects.solids import revolve, rounded_rectangle, sweep

WHITE = (238, 236, 228)
RED, BLUE, YELLOW, GREEN = (196, 70, 54), (52, 98, 158), (230, 186, 60), (74, 124, 84)
SLATE, PURPLE, APRICOT = (84, 88, 98), (128, 84, 132), (214, 132, 90)
GLAZES = (WHITE, RED, BLUE, YELLOW, GREEN, SLATE, PURPLE, APRICOT)


def build(rng: np.random.Generator) -> Mesh:
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
    outline = rounded_rectangle(*rng.uniform((0.006, 0.009), (0.009, 0.014)), radius=0.0025, segments=3)
    return sweep(outline, np.column_stack([0 * y, y, z]), up=(1, 0, 0))
