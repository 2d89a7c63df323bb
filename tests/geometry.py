"""Random rigid motions and small scanned objects for tests."""

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.recorder import poses
from orbitscan.recorder.session import Session, SessionInfo, View, in_memory

# The blob's bumps: four large ones, and knobs that features tell apart, as no two are of one size.
_DRAWN = np.random.default_rng(7)
_LARGE = [(0.9, 0.3, 0.2), (-0.5, 0.8, 0.1), (0.1, -0.7, 0.7), (-0.2, -0.3, -0.9)]
_BUMPS = np.vstack([_LARGE, _DRAWN.normal(size=(60, 3))])
_BUMPS /= np.linalg.norm(_BUMPS, axis=1, keepdims=True)
_HEIGHTS = np.concatenate([[0.035, 0.05, 0.04, 0.03], _DRAWN.uniform(0.004, 0.012, size=60)])
_SHARPNESS = np.concatenate([[8, 12, 16, 20], _DRAWN.uniform(60, 200, size=60)])


def random_pose(rng, angle=None, shift=1.0):
    """A random motion; by at most `angle` radians where one is given."""
    if angle is None:
        R = Rotation.random(rng=rng).as_matrix()
    else:
        R = Rotation.from_rotvec(rng.normal(size=3) * angle / 3).as_matrix()
    return poses.make(R, rng.normal(size=3) * shift)


def blob(rng, points=20_000):
    """Points (N, 3) and outward normals of a bumpy closed surface without symmetry, some 30 cm large."""
    u = rng.normal(size=(points, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    bumps = _HEIGHTS * np.exp((u @ _BUMPS.T - 1) * _SHARPNESS)
    radius = 0.1 + bumps.sum(axis=1) + 0.004 * np.sin(9 * u[:, 0] + 2) * np.sin(7 * u[:, 1] + 1)
    slope = (bumps * _SHARPNESS) @ _BUMPS
    slope[:, 0] += 0.036 * np.cos(9 * u[:, 0] + 2) * np.sin(7 * u[:, 1] + 1)
    slope[:, 1] += 0.028 * np.sin(9 * u[:, 0] + 2) * np.cos(7 * u[:, 1] + 1)
    slope -= np.einsum("ni,ni->n", slope, u)[:, None] * u
    normals = u - slope / radius[:, None]
    return u * radius[:, None], normals / np.linalg.norm(normals, axis=1, keepdims=True)


def sphere(rng, points=20_000):
    """Points (N, 3) and outward normals of a sphere of 10 cm radius about the origin."""
    u = rng.normal(size=(points, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return 0.1 * u, u


def cylinder(rng, points=20_000):
    """Points (N, 3) and outward normals of a cylinder's side about the z axis, 10 cm wide and 20 cm high."""
    angle, z = 2 * np.pi * rng.random(points), 0.2 * rng.random(points) - 0.1
    normals = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(points)])
    return 0.05 * normals + z[:, None] * [0, 0, 1], normals


def plane(rng, points=20_000):
    """Points (N, 3) and normals of a square of 20 cm, facing along the x axis."""
    normals = np.tile([1.0, 0, 0], (points, 1))
    return np.column_stack([np.zeros(points), rng.uniform(-0.1, 0.1, size=(points, 2))]), normals


def bottle(rng, points=20_000):
    """Points (N, 3) and outward normals of a surface of revolution about the z axis, with a belly, a neck and a rim."""
    angle, z = 2 * np.pi * rng.random(points), 0.24 * rng.random(points) - 0.12
    radius = 0.05 + 0.015 * np.sin(28 * z) - 0.02 * np.tanh(60 * (z - 0.05))
    slope = 0.42 * np.cos(28 * z) - 1.2 / np.cosh(60 * (z - 0.05)) ** 2
    around = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(points)])
    normals = (around - slope[:, None] * [0, 0, 1]) / np.sqrt(1 + slope**2)[:, None]
    return radius[:, None] * around + z[:, None] * [0, 0, 1], normals


def scan(n_views=4, step_deg=20.0, noise=0.0005, points=20_000, seed=0, surface=blob) -> Session:
    """A session of an object on a turntable before a camera one metre away; the true poses are known.

    Every view samples the surface anew, as a sensor does.
    """
    rng = np.random.default_rng(seed)
    views, truth = [], {}
    for i in range(n_views):
        sampled, normals = surface(rng, points)
        turn = Rotation.from_euler("z", i * step_deg, degrees=True).as_matrix()
        eye = turn @ np.array([0.9, 0.0, 0.4])
        forward = -eye / np.linalg.norm(eye)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        T_object_camera = poses.make(np.column_stack([right, np.cross(forward, right), forward]), eye)
        facing = np.einsum("ni,ni->n", normals, eye - sampled) > 0.1
        local = poses.transform(poses.invert(T_object_camera), sampled[facing])
        local = local[~_hidden(local)]
        local[:, 2] += rng.normal(scale=noise, size=len(local))
        views.append(View(i, f"view_{i:03d}", (i + 1) * 10**9, local.astype(np.float32)))
        truth[i] = T_object_camera
    return in_memory(SessionInfo(surface.__name__, n_views, capture="circle"), views, truth)


def _hidden(local, pixel=0.004, behind=0.01):
    """Which points (N, 3) before a camera lie farther behind their surroundings than a slope explains."""
    columns, rows = ((local[:, :2] / local[:, 2:] + 0.5) / pixel).astype(int).T
    nearest = np.full((int(1 / pixel),) * 2, np.inf)
    np.minimum.at(nearest, (rows, columns), local[:, 2])
    return local[:, 2] > nearest[rows, columns] + behind
