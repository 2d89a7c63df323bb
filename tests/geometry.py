"""Random rigid motions and small scanned objects for tests."""

import numpy as np
from scipy.spatial.transform import Rotation

from recorder import poses
from recorder.session import Session, SessionInfo, View, in_memory


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
    bumps = [((0.9, 0.3, 0.2), 0.35), ((-0.5, 0.8, 0.1), 0.5), ((0.1, -0.7, 0.7), 0.4), ((-0.2, -0.3, -0.9), 0.3)]
    radius = np.full(points, 0.1)
    for k, (direction, height) in enumerate(bumps):
        d = np.array(direction) / np.linalg.norm(direction)
        radius += 0.1 * height * np.exp((u @ d - 1) * (8 + 4 * k))
    radius += 0.004 * np.sin(9 * u[:, 0] + 2) * np.sin(7 * u[:, 1] + 1) + 0.003 * np.sin(11 * u[:, 2])
    return u * radius[:, None], u


def scan(n_views=4, step_deg=20.0, noise=0.0005, points=20_000, seed=0) -> Session:
    """A session of a blob on a turntable before a camera one metre away; the true poses are known."""
    rng = np.random.default_rng(seed)
    surface, normals = blob(rng, points)
    views, truth = [], {}
    for i in range(n_views):
        turn = Rotation.from_euler("z", i * step_deg, degrees=True).as_matrix()
        eye = turn @ np.array([0.9, 0.0, 0.4])
        forward = -eye / np.linalg.norm(eye)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        T_object_camera = poses.make(np.column_stack([right, np.cross(forward, right), forward]), eye)
        seen = np.einsum("ni,ni->n", normals, eye - surface) > 0.25
        local = poses.transform(poses.invert(T_object_camera), surface[seen])
        local[:, 2] += rng.normal(scale=noise, size=len(local))
        views.append(View(i, f"view_{i:03d}", (i + 1) * 10**9, local.astype(np.float32)))
        truth[i] = T_object_camera
    return in_memory(SessionInfo("blob", n_views, capture="circle"), views, truth)
