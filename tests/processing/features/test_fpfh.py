"""FPFH by Open3D: how it relates to PCL's values, and what holds on any view."""

import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from orbitscan.processing.features import fpfh
from orbitscan.recorder.exceptions import MissingLibrary

RADIUS = 0.02
REFERENCE = Path(__file__).parents[2] / "reference"


@pytest.fixture(scope="module")
def view():
    """What the first 20 keypoints need of the view: their neighbours' neighbours."""
    view = np.load(REFERENCE / "pcl_robot_view.npz")
    points, normals, keypoints = (view[name].astype(float) for name in ("points", "normals", "keypoints"))
    near = cKDTree(keypoints[:20]).query(points)[0] < 2.1 * RADIUS
    return points[near], normals[near], keypoints[:20]


def simple_histograms(points, normals, at):
    """SPFH (33,) of point `at` among its neighbours: alpha, phi and theta of its pairs, of sum 100 each."""
    d = np.delete(points, at, axis=0) - points[at]
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    mine, theirs = np.broadcast_to(normals[at], d.shape), np.delete(normals, at, axis=0)
    theta = (mine * d).sum(axis=1)
    swap = (np.abs((theirs * d).sum(axis=1)) > np.abs(theta))[:, None]
    u, m = np.where(swap, theirs, mine), np.where(swap, mine, theirs)
    d = np.where(swap, -d, d)
    theta = (u * d).sum(axis=1)
    v = np.cross(d, u)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    alpha = np.arctan2((np.cross(u, v) * m).sum(axis=1), (u * m).sum(axis=1))
    shares = [(alpha + np.pi) / (2 * np.pi), ((v * m).sum(axis=1) + 1) / 2, (theta + 1) / 2]
    return np.concatenate([np.histogram(s, bins=11, range=(0, 1))[0] for s in shares]) * (100 / len(d))


def test_it_is_pcls_plus_the_keypoints_own_simple_histograms(view, open3d):
    points, normals, keypoints = view
    reference = np.load(REFERENCE / "pcl_descriptors.npz")["fpfh"]
    tree = cKDTree(points)
    own = []
    for nearest in tree.query(keypoints)[1]:
        ball = np.array(tree.query_ball_point(points[nearest], RADIUS))
        own.append(simple_histograms(points[ball], normals[ball], int(np.flatnonzero(ball == nearest)[0])))
    descriptors = fpfh.describe(points, normals, keypoints, RADIUS)
    assert np.abs(descriptors - own - reference).max() < 1e-6 * 100


def test_each_of_three_histograms_sums_to_200(view, open3d):
    descriptors = fpfh.describe(*view, RADIUS)
    assert descriptors.shape == (20, fpfh.LENGTH)
    assert np.allclose(descriptors.reshape(20, 3, 11).sum(axis=2), 200, atol=1e-3)


def test_it_hardly_changes_when_the_view_moves(view, open3d):
    points, normals, keypoints = view
    R = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    before = fpfh.describe(points, normals, keypoints, RADIUS)
    after = fpfh.describe(points @ R.T + 1, normals @ R.T, keypoints @ R.T + 1, RADIUS)
    assert np.median(np.abs(before - after).max(axis=1)) < 1e-3


def test_without_neighbours_or_normals_it_is_nan(open3d):
    rng = np.random.default_rng(0)
    points = np.vstack([rng.random((100, 3)), [[9.0, 9.0, 9.0]]])
    normals = np.tile([0.0, 0.0, 1.0], (101, 1))
    keypoints = np.array([points[0], [9.0, 9.0, 9.0], [-9.0, 0.0, 0.0]])  # among others, alone, where nothing is
    assert np.isnan(fpfh.describe(points, normals, keypoints, 0.5)).all(axis=1).tolist() == [False, True, True]
    assert np.isnan(fpfh.describe(points, np.full((101, 3), np.nan), keypoints, 0.5)).all()


def test_without_open3d_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "open3d", None)
    with pytest.raises(MissingLibrary, match=r"open3d: cannot be loaded .*; install what is missing"):
        fpfh.describe(np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 3)), 0.1)
