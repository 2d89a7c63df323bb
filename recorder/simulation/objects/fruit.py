"""What grown things have in common: no two sides are alike, and they rest where their weight takes them."""

from dataclasses import replace

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from orbitscan.recorder.mesh import Mesh


def bumps(rng: np.random.Generator, directions: np.ndarray, amplitude: float) -> np.ndarray:
    """A smooth random field (...) over unit directions (..., 3): a few waves a turn, `amplitude` its usual size."""
    waves = rng.normal(size=(8, 3))
    waves *= rng.uniform(1.2, 4.0, (8, 1)) / np.linalg.norm(waves, axis=1, keepdims=True)
    phases = rng.uniform(0, 2 * np.pi, 8)
    return amplitude / 2 * np.cos(directions @ waves.T + phases).sum(axis=-1)


def settled(mesh: Mesh, tilt_deg: float, reach_deg: float) -> Mesh:
    """The closed mesh, tilted from z towards +x and come to rest, its former z axis leaning towards +x again.

    It rests on the face of its convex hull, no farther than `reach_deg` from below, over which its centre is lowest.
    """
    tilted = mesh.turned("y", tilt_deg)
    hull = ConvexHull(tilted.vertices)
    normals, offsets = hull.equations[:, :3], hull.equations[:, 3]
    heights = -(normals @ _centroid(tilted) + offsets)
    heights[normals[:, 2] > -np.cos(np.radians(reach_deg))] = np.inf
    down = normals[np.argmin(heights)] if np.isfinite(heights).any() else np.array([0, 0, -1.0])
    rest = Rotation.align_vectors([[0, 0, -1]], [down])[0] * Rotation.from_euler("y", tilt_deg, degrees=True)
    x, y, _ = rest.apply([0, 0, 1])
    return replace(mesh, vertices=(Rotation.from_euler("z", -np.arctan2(y, x)) * rest).apply(mesh.vertices))


def _centroid(mesh: Mesh) -> np.ndarray:
    """The centre (3,) of the volume within a closed mesh."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    volumes = np.einsum("ti,ti->t", a, np.cross(b, c))
    return volumes @ (a + b + c) / (4 * volumes.sum())
