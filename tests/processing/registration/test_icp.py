"""The thesis's point-to-point ICP: exact on identical points, and honest where there is nothing to pair."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from orbitscan.processing.registration.icp import icp
from orbitscan.recorder import poses
from tests.geometry import blob, random_pose


@pytest.fixture(scope="module")
def surface():
    return blob(np.random.default_rng(0), 4000)[0]


def test_point_to_point_finds_identical_points_exactly(surface):
    T = random_pose(np.random.default_rng(1), angle=0.08, shift=0.003)
    moved = poses.transform(T, surface)
    found = icp(surface, cKDTree(moved), np.eye(4), 0.05, 200, 1e-9)
    assert found.converged
    assert np.allclose(found.T_target_source, T, atol=1e-6)


def test_nothing_within_the_gate_is_no_convergence(surface):
    far = cKDTree(surface + 10)
    found = icp(surface, far, np.eye(4), 0.01, 10, 1e-9)
    assert not found.converged
    assert (found.T_target_source == np.eye(4)).all()
