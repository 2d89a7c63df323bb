"""Surfels correspond to the nearest that face the same way, in any number."""

import numpy as np

from orbitscan.processing.registration.correspondences import find_correspondences, make_target
from orbitscan.processing.surface.preparation import Surfels


def test_correspondences_are_the_nearest_that_face_the_same_way():
    rng = np.random.default_rng(0)
    points, normals = rng.random((300, 3)), rng.normal(size=(300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    target = make_target(Surfels(points, normals, np.ones(300)), 0.2)
    asked, facing = rng.random((100, 3)), np.roll(normals, 1, axis=0)[:100]
    found = find_correspondences(asked, facing, target, 0.2)
    for i in range(100):
        distance = np.linalg.norm(target.grid.points - asked[i], axis=1)
        distance[(target.normals @ facing[i] <= 0.5) | (distance >= 0.2)] = np.inf
        expected = int(distance.argmin()) if np.isfinite(distance).any() else -1
        assert found[i] == expected
    assert (found >= 0).any()
    assert (found < 0).any()
