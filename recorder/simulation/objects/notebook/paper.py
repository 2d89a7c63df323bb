"""What notebooks are made of: sheets that bend and wave, stacks of pages, coils of wire; their sizes and colours."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.solids import circle, sweep

FORMATS = (  # height and width of a page [m]
    (0.148, 0.105),  # A6
    (0.140, 0.090),  # pocket
    (0.210, 0.130),
    (0.210, 0.148),  # A5
    (0.241, 0.152),
    (0.250, 0.176),  # B5
    (0.247, 0.190),  # composition
    (0.267, 0.203),
    (0.279, 0.216),  # letter
    (0.297, 0.210),  # A4
)
PAPER, LINE, CARD = (236, 234, 224), (168, 186, 208), (176, 152, 118)
BLACK, NAVY, RED, GREEN, YELLOW = (44, 44, 48), (44, 62, 116), (182, 46, 48), (58, 122, 84), (232, 196, 72)
PURPLE, TEAL, PINK, BROWN, GREY = (112, 72, 140), (54, 138, 146), (224, 142, 170), (112, 78, 56), (132, 136, 142)
COVERS = (BLACK, NAVY, RED, GREEN, YELLOW, PURPLE, TEAL, PINK, BROWN, GREY)
WIRES = ((60, 60, 64), (190, 192, 196), (222, 222, 220))
ACROSS = 19  # points along x of a sheet

Rise = Callable[[np.ndarray, np.ndarray], np.ndarray]  # a height of x and y, all of one shape [m]


def page_size(rng: np.random.Generator, largest: float = 0.30) -> tuple[float, float]:
    """The height and width [m] of a page of one of the formats, one in six turned to landscape."""
    fitting = [size for size in FORMATS if max(size) <= largest]
    height, width = rng.uniform(0.97, 1.01) * np.array(fitting[rng.integers(len(fitting))])
    return (width, height) if rng.random() < 1 / 6 else (height, width)


def cover_colors(rng: np.random.Generator) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    """The colour of a cover, and another one for what is on it."""
    first, second = rng.permutation(len(COVERS))[:2]
    return COVERS[first], COVERS[second]


def waves(rng: np.random.Generator, length: float, width: float, height: float) -> Rise:
    """How far paper that was wet or handled rises above its plane: a smooth function of x and y, below `height` [m]."""
    turns = rng.uniform(-1.3, 1.3, (3, 2)) * 2 * np.pi / (length, width)
    phases = rng.uniform(0, 2 * np.pi, 3)
    shares = rng.dirichlet(np.ones(3))

    def rise(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        angles = x[..., None] * turns[:, 0] + y[..., None] * turns[:, 1] + phases
        return height * (shares * (0.5 + 0.5 * np.sin(angles))).sum(axis=-1)

    return rise


def stack(
    length: float,
    profile: np.ndarray,
    thickness: np.ndarray | float,
    corner: float = 0.0,
    rise: Rise = lambda x, _: np.zeros_like(x),
) -> Mesh:
    """Paper of a thickness [m] (one, or one per point) upon a curve (S, 2) of y and z, its length along x.

    It starts at the spine; at the curve's far end its corners are rounded by `corner` [m]. All of it rises by `rise`
    of x and y.
    """
    profile = np.asarray(profile, dtype=np.float64)
    steps = np.linalg.norm(np.diff(profile, axis=0), axis=1)
    left = np.append(np.cumsum(steps[::-1])[::-1], 0)
    cut = np.clip(1 - left / corner, 0, 1) if corner > 0 else np.zeros(len(left))
    half = length / 2 - corner * (1 - np.sqrt(1 - cut**2))
    tangent = np.gradient(profile, axis=0)
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]]) / np.linalg.norm(tangent, axis=1, keepdims=True)
    if profile[-1, 0] < profile[0, 0]:
        normal = -normal
    across = np.linspace(-1, 1, ACROSS)

    def surface(curve: np.ndarray) -> np.ndarray:
        x = half[:, None] * across
        y, z = (np.broadcast_to(side[:, None], x.shape) for side in curve.T)
        return np.stack([x, y, z + rise(x, np.broadcast_to(profile[:, :1], x.shape))], axis=-1)

    lower = surface(profile)
    upper = surface(profile + normal * np.broadcast_to(thickness, len(profile))[:, None])
    return _closed(np.concatenate([lower, upper[:, ::-1]], axis=1))


def _closed(rings: np.ndarray) -> Mesh:
    """The solid within rings (S, 2 N, 3) that run along N points below and back above them, closed by strips.

    Unlike the fans of a loft these follow bent ends.
    """
    count, n = rings.shape[:2]
    grid = np.arange(count * n).reshape(count, n)
    here, there = grid, np.roll(grid, -1, axis=1)
    a, b = np.arange(n // 2 - 1), n - 1 - np.arange(n // 2 - 1)
    strip = np.concatenate([np.column_stack([a, a + 1, b - 1]), np.column_stack([a, b - 1, b])])
    triangles = [
        np.stack([here[:-1], there[:-1], there[1:]], axis=-1).reshape(-1, 3),
        np.stack([here[:-1], there[1:], here[1:]], axis=-1).reshape(-1, 3),
        strip[:, ::-1],
        strip + (count - 1) * n,
    ]
    mesh = Mesh(rings.reshape(-1, 3), np.concatenate(triangles))
    return mesh if mesh.volume > 0 else Mesh(mesh.vertices, mesh.triangles[:, ::-1])


def level(width: float, z: float = 0.0, start: float = 0.0, corner: float = 0.0) -> np.ndarray:
    """A flat profile for a stack: from y = `start` over a width (to the left if negative) [m], fine at its far end."""
    far = np.sign(width) * min(max(corner, 0.001), abs(width) / 2)
    y = np.concatenate([np.linspace(0, width - far, 10)[:-1], width - far * np.cos(np.linspace(0, np.pi / 2, 5))])
    return np.column_stack([start + y, np.full(len(y), z)])


def ruled(sheet: Mesh, rng: np.random.Generator) -> Mesh:
    """Paper, plain or with lines along y."""
    row = np.arange(len(sheet.vertices)) % (2 * ACROSS)
    column = np.minimum(row, 2 * ACROSS - 1 - row)
    if rng.random() >= 0.7:
        return sheet.painted(PAPER)
    lined = (column % 3 == 1) & (column > 2)
    return replace(sheet, colors=np.where(lined[:, None], LINE, PAPER).astype(np.uint8))


def bent(length: float, degrees: np.ndarray, start: tuple[float, float]) -> np.ndarray:
    """The profile of a leaf of a length [m] from y and z at the spine, by its slopes from there to its free edge."""
    slopes = np.radians(np.interp(np.linspace(0, 1, 14), np.linspace(0, 1, len(degrees)), degrees))
    steps = length / 14 * np.column_stack([np.cos(slopes), np.sin(slopes)])
    return np.array(start) + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def coil(rng: np.random.Generator, length: float, radius: float) -> Mesh:
    """A spiral of wire about the x axis, or as many rings as it would have turns, all joined to a helix [m]."""
    turns = int(np.clip(length / rng.uniform(0.0065, 0.0110), 8, 36))
    angle = np.linspace(0, 2 * np.pi * turns, 12 * turns + 1)
    wire = rng.uniform(0.0006, 0.0013)
    rung = np.linspace(-length / 2, length / 2, len(angle))
    if rng.random() < 0.4:  # rings: the wire crosses to the next one below
        rung = np.interp(angle / (2 * np.pi) % 1, [0.0, 0.25, 1], [0, 1, 1]) + np.floor(angle / (2 * np.pi))
        rung = (rung / rung.max() - 0.5) * length
    path = np.column_stack([rung, -radius * np.sin(angle), -radius * np.cos(angle)])
    return sweep(circle(wire, 5), path, up=(1, 0, 0))
