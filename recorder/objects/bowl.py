"""Bowls: hollow surfaces of revolution on a foot ring, 12 to 18 cm across; no turn about z can be seen."""

import numpy as np

from recorder.objects.mesh import Mesh
from recorder.objects.solids import revolve

SEGMENTS = 96  # facets this fine are no features
CLAY, WHITE = (176, 132, 100), (238, 236, 228)
RED, BLUE, TEAL, GREEN = (172, 62, 50), (48, 84, 146), (62, 138, 140), (104, 128, 82)
SAND, SLATE, MUSTARD = (206, 180, 144), (84, 88, 98), (212, 162, 58)
GLAZES = (WHITE, RED, BLUE, TEAL, GREEN, SAND, SLATE, MUSTARD)


def build(rng: np.random.Generator) -> Mesh:
    """A bowl; instances differ in size, in the wall (from bellied to a cone, with or without a flare) and in glazes."""
    radius, height, thickness = rng.uniform((0.060, 0.050, 0.0030), (0.088, 0.085, 0.0048))
    foot = radius * rng.uniform(0.40, 0.58)
    lift = rng.uniform(0.004, 0.010)
    outside = _wall(foot, radius, lift, height, rng.uniform(0.75, 1.6), rng.uniform(0, 0.006) * rng.integers(2))
    inside = _inward(outside, thickness)
    lip = [(outside[-1, 0] - share * thickness, height + 0.25 * thickness) for share in (0.3, 0.7)]
    ring = [(0, 0.6 * lift), (foot - 0.010, 0.5 * lift), (foot - 0.007, 0), (foot - 0.001, 0), (foot, 0.4 * lift)]
    mesh = revolve(np.array([*ring, *outside, *lip, *inside[::-1], (0, inside[0, 1])]), SEGMENTS)
    return Mesh(mesh.vertices, mesh.triangles, _glaze(rng, mesh, len(ring), len(outside)))


def _wall(foot: float, radius: float, lift: float, height: float, exponent: float, flare: float) -> np.ndarray:
    """The outer wall (P, 2) from the foot to the rim: a superellipse, straight at exponent 2, flared near the rim."""
    angles = np.linspace(0, np.pi / 2, 17)
    out, up = np.sin(angles) ** exponent, 1 - np.cos(angles) ** exponent
    wall = np.column_stack([foot + (radius - flare - foot) * out, lift + (height - lift) * up])
    wall[:, 0] += flare * up**3
    return wall


def _inward(wall: np.ndarray, thickness: float) -> np.ndarray:
    """The wall (P, 2), moved along its normals to the inside, its rim level with the wall's."""
    along = np.gradient(wall, axis=0)
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.linalg.norm(along, axis=1, keepdims=True)
    inside = wall + thickness * normals
    inside[-1] = wall[-1] - (thickness, 0)
    return inside


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
