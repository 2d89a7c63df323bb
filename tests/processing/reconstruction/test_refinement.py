"""Both kinds of ICP come back to a pose they are started near to."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from processing.reconstruction import refinement
from processing.reconstruction.refinement import RefinementSettings
from recorder import poses
from tests.geometry import blob, random_pose

HOW = RefinementSettings()


def angle_deg(T):
    return np.degrees(poses.rotation_angle(T[:3, :3]))


@pytest.fixture(scope="module")
def surface():
    points, _ = blob(np.random.default_rng(0), 4000)
    return points


def test_point_to_point_finds_identical_points_exactly(surface):
    T = random_pose(np.random.default_rng(1), angle=0.08, shift=0.003)
    moved = poses.transform(T, surface)
    found = refinement.icp(surface, cKDTree(moved), np.eye(4), 0.05, 200, 1e-9)
    assert found.converged
    assert np.allclose(found.T_target_source, T, atol=1e-6)


def test_generalized_icp_aligns_two_samplings_of_one_surface():
    source, _ = blob(np.random.default_rng(1), 6000)
    target, _ = blob(np.random.default_rng(2), 6000)
    T = random_pose(np.random.default_rng(3), angle=0.08, shift=0.003)
    clouds = [refinement.make_searchable(p, HOW.neighbours) for p in (source, poses.transform(T, target))]
    found = refinement.generalized_icp(*clouds, np.eye(4), 0.03, 50, HOW.fine_still)
    off = poses.invert(T) @ found.T_target_source
    assert found.converged
    assert angle_deg(off) < 0.1
    assert np.linalg.norm(off[:3, 3]) < 2e-4
    plain = refinement.icp(source, cKDTree(poses.transform(T, target)), np.eye(4), 0.03, 50, 1e-7)
    assert angle_deg(poses.invert(T) @ plain.T_target_source) > angle_deg(off)


def test_nothing_within_the_gate_is_no_convergence(surface):
    far = cKDTree(surface + 10)
    found = refinement.icp(surface, far, np.eye(4), 0.01, 10, 1e-9)
    assert not found.converged
    assert (found.T_target_source == np.eye(4)).all()
