"""What phones are made of: rounded bodies, screens, keys, antennas; and how they are put down. Bodies lie on z = 0."""

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.solids import box, circle, loft, prism, rounded_rectangle

BLACK, GRAPHITE, SILVER, WHITE, CREAM = (38, 38, 42), (84, 86, 92), (186, 188, 194), (232, 232, 230), (214, 206, 188)
NAVY, RED, PINK, TEAL, GOLD = (40, 58, 108), (176, 40, 44), (226, 136, 168), (52, 128, 132), (204, 178, 128)
SHELLS = (BLACK, GRAPHITE, SILVER, WHITE, CREAM, NAVY, RED, PINK, TEAL, GOLD)
GLASS, BEZEL, LIT = (22, 24, 30), (48, 50, 56), (118, 140, 152)
SEGMENTS = 8  # to a corner of a body


def shell_colors(rng: np.random.Generator) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    """The colour of a body, and another one for its keys and trim."""
    first, second = rng.permutation(len(SHELLS))[:2]
    return SHELLS[first], SHELLS[second]


def body(
    length: float,
    width: float,
    thickness: float,
    corner: float,
    edges: tuple[float, float] = (0.002, 0.002),
    barrel: float = 0.0,
    ends: float = 0.0,
    lip: float = 0.0,
) -> Mesh:
    """A flat body, length along x, its corners and its lower and upper edges rounded by the given radii [m].

    Its sides swell by `barrel` and its ends by `ends` of width and length (negative: they are drawn in). A `lip` [m]
    leaves the top recessed by as much within a rim, as a case about a telephone does.
    """
    x, y = rounded_rectangle(length, width, corner, SEGMENTS).T
    outline = np.column_stack(
        [x * (1 + ends * (1 - (2 * y / width) ** 2)), y * (1 + barrel * (1 - (2 * x / length) ** 2))]
    )
    turns = np.linspace(0, np.pi / 2, 5)
    lower, upper = edges
    high = min(lower, 0.45 * thickness), min(upper, 0.45 * thickness)
    layers = [
        *zip(lower * (1 - np.sin(turns)), high[0] * (1 - np.cos(turns)), strict=True),
        *zip(upper * (1 - np.cos(turns)), thickness - high[1] * (1 - np.sin(turns)), strict=True),
    ]
    if lip:
        layers += [(upper + 0.0012, thickness), (upper + 0.0016, thickness - lip)]
    span = np.ptp(outline, axis=0)
    return loft([np.column_stack([outline * (1 - 2 * inset / span), np.full(len(x), z)]) for inset, z in layers])


def plate(length: float, width: float, corner: float = 0.0015, height: float = 0.0008) -> Mesh:
    """A screen, a lens or a lid: a thin plate with rounded corners, half sunk into z = 0 [m]."""
    return prism(rounded_rectangle(length, width, corner, 4), height).moved(z=-height / 2)


def keypad(length: float, width: float, rows: int, columns: int, height: float, fill: float = 0.8) -> list[Mesh]:
    """Rows of keys on z = 0 within length times width [m], each key `fill` of its cell."""
    cell = length / rows, width / columns
    key = box(fill * cell[0], fill * cell[1], height + 0.001, 0.0004).moved(z=-0.001)
    return [
        key.moved((row + 0.5) * cell[0] - length / 2, (column + 0.5) * cell[1] - width / 2)
        for row in range(rows)
        for column in range(columns)
    ]


def antenna(rng: np.random.Generator, reach: float) -> Mesh:
    """A stub that sticks out towards -x by `reach` [m], its foot at the origin."""
    radius, tip = rng.uniform((0.0026, 0.6), (0.0046, 1.0))
    sections = [(0.004, 1), (-0.25 * reach, 1), (-0.3 * reach, 0.85), (-0.95 * reach, 0.85 * tip), (-reach, 0.5 * tip)]
    return loft([np.column_stack([np.full(16, x), circle(radius * share, 16)]) for x, share in sections])


def put_down(rng: np.random.Generator, phone: Mesh, thickness: float) -> Mesh:
    """The phone as it comes to lie: mostly flat, at times on its face, propped up, leaning back or on an edge."""
    how = rng.random()
    if how < 0.55:
        return phone.turned("y", rng.uniform(0, 2))
    if how < 0.67:
        return phone.moved(z=-thickness / 2).turned("x", 180).turned("y", rng.uniform(-2, 4))
    if how < 0.80:
        return phone.turned("y", rng.uniform(3, 16)).turned("x", rng.uniform(-10, 10))
    if how < 0.89:
        return phone.turned("y", rng.uniform(40, 78))
    return phone.turned("z", -90).turned("y", rng.uniform(45, 92))  # on its long edge
