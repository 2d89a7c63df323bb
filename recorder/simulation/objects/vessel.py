"""Walls drawn round the z axis: silhouettes of vessels, sections from round to square, and the hollow within."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.solids import circle, loft

SEGMENTS = 96  # facets this fine are no features

Color = tuple[int, int, int]


def silhouette(height: float, radii: tuple[float, ...], fillet: float = 0.004, count: int = 14) -> np.ndarray:
    """A smooth wall (P, 2) of radius and height [m] from z = 0 through radii at even heights, its foot rounded off."""
    curve = PchipInterpolator(np.linspace(0, height, len(radii)), radii)
    levels = np.linspace(fillet, height, count)
    turns = np.radians([0, 30, 60])
    foot = np.column_stack([curve(fillet) - fillet * (1 - np.sin(turns)), fillet * (1 - np.cos(turns))])
    return np.concatenate([foot, np.column_stack([curve(levels), levels])])


def coupe(foot: float, radius: float, lift: float, height: float, exponent: float, flare: float = 0.0) -> np.ndarray:
    """A bowl's outer wall (17, 2) [m] from the foot to the rim: a superellipse, straight at exponent 2, flared at the
    rim; `lift` is the height of its foot."""
    angles = np.linspace(0, np.pi / 2, 17)
    out, up = np.sin(angles) ** exponent, 1 - np.cos(angles) ** exponent
    wall = np.column_stack([foot + (radius - flare - foot) * out, lift + (height - lift) * up])
    wall[:, 0] += flare * up**3
    return wall


def inward(wall: np.ndarray, thickness: float) -> np.ndarray:
    """The wall (P, 2), moved along its normals to the inside."""
    along = np.gradient(wall, axis=0)
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    return wall + thickness * normals


def superellipse(exponent: float, aspect: float = 1.0, segments: int = SEGMENTS) -> np.ndarray:
    """An outline (N, 2) from a circle (exponent 2) towards a square, 1 wide at y = 0 and `aspect` at x = 0."""
    x, y = circle(1, segments).T
    radii = (np.abs(x) ** exponent + np.abs(y / aspect) ** exponent) ** (-1 / exponent)
    return circle(1, segments) * radii[:, None]


def fluted(count: int, depth: float, segments: int = SEGMENTS) -> np.ndarray:
    """A circle's outline (N, 2) with waves about it, `depth` the share of the radius from crest to trough."""
    angles = 2 * np.pi * np.arange(segments) / segments
    return circle(1, segments) * (1 - depth * (1 - np.cos(count * angles)) / 2)[:, None]


def polygon(sides: int, segments: int = SEGMENTS) -> np.ndarray:
    """The outline (N, 2) of a regular polygon, its corners on the unit circle."""
    angles = 2 * np.pi * np.arange(segments) / segments
    turn = angles % (2 * np.pi / sides) - np.pi / sides
    return circle(1, segments) * (np.cos(np.pi / sides) / np.cos(turn))[:, None]


def lathe(profile: np.ndarray, outline: np.ndarray | None = None, weights: np.ndarray | float = 1.0) -> Mesh:
    """A profile (P, 2) of radius and height [m] drawn round the z axis along a unit outline (N, 2), a circle if None.

    Every row's section is a mean of the circle and the outline, `weights` (P,) the outline's share.
    """
    profile = np.asarray(profile, dtype=np.float64)
    unit = circle(1, SEGMENTS if outline is None else len(outline))
    shares = np.broadcast_to(weights, len(profile))[:, None, None]
    sections = unit if outline is None else (1 - shares) * unit + shares * outline
    rings = profile[:, :1, None] * sections
    heights = np.broadcast_to(profile[:, 1, None, None], (*rings.shape[:2], 1))
    return loft(np.concatenate([rings, heights], axis=2))


def hollow(
    wall: np.ndarray,
    thickness: float,
    floor: float,
    colors: tuple[Color, Color],
    outline: np.ndarray | None = None,
    foot_share: float = 1.0,
) -> Mesh:
    """An open vessel of an outer wall (P, 2) [m] from the foot to the rim: a colour outside, another inside.

    `floor` is the height of the bottom inside; the section grows from `foot_share` of the outline at the foot to all
    of it at the rim.
    """
    inside = inward(wall, thickness)
    bottom = np.interp(floor, *inside[np.argsort(inside[:, 1])].T[::-1]) - 0.3 * thickness
    inside = inside[(inside[:, 1] > floor + 0.5 * thickness) & (inside[:, 0] > 0)]
    onward = wall[-1] - wall[-2]
    lip = 0.35 * thickness * onward / np.linalg.norm(onward)
    rim = [wall[-1] + share * (inside[-1] - wall[-1]) + lip for share in (0.3, 0.7)]
    profile = np.array([(0, wall[0, 1]), *wall, *rim, *inside[::-1], (bottom, floor), (0, floor)])
    weights = foot_share + (1 - foot_share) * np.clip(profile[:, 1] / wall[-1, 1], 0, 1)
    mesh = lathe(profile, outline, weights)
    rows = np.arange(1, len(profile) - 1) > len(wall) + 1
    segments = SEGMENTS if outline is None else len(outline)
    painted = np.repeat(np.array(colors, np.uint8)[rows.astype(int)], segments, axis=0)
    return Mesh(mesh.vertices, mesh.triangles, np.concatenate([painted, np.array(colors, np.uint8)]))
