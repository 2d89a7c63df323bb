"""PFH against PCL's values, and what holds on any view."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.processing.features import pfh

RADIUS = 0.02
REFERENCE = Path(__file__).parents[2] / "reference"


@pytest.fixture(scope="module")
def view():
    view = np.load(REFERENCE / "pcl_robot_view.npz")
    return view["points"], view["normals"], view["keypoints"][:50]


def test_pfh_is_pcls_within_a_hundred_thousandth_of_the_sum(view):
    # One pair in another bin would be more than that.
    reference = np.load(REFERENCE / "pcl_descriptors.npz")["pfh"]
    assert np.abs(pfh.describe(*view, RADIUS) - reference).max() < 1e-5 * 100


def test_pfh_hardly_changes_when_the_view_moves(view):
    points, normals, keypoints = (a.astype(float) for a in view)
    R = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    before = pfh.describe(points, normals, keypoints, RADIUS)
    after = pfh.describe(points @ R.T + 1, normals @ R.T, keypoints @ R.T + 1, RADIUS)
    assert np.abs(before - after).sum(axis=1).max() < 0.1  # of 100


def test_a_plane_has_one_bin():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.random((200, 2)), np.zeros(200)])
    normals = np.tile([0.0, 0.0, 1.0], (200, 1))
    descriptor = pfh.describe(points, normals, points[:1], 0.5)[0]
    middle = pfh.STEPS // 2
    assert np.flatnonzero(descriptor).tolist() == [middle * (1 + pfh.STEPS + pfh.STEPS**2)]
    assert descriptor.sum() == pytest.approx(100, abs=0.02)


def test_points_without_normals_do_not_count(view):
    points, normals, keypoints = view
    keypoints = keypoints[:5]
    unknown = np.random.default_rng(0).random(len(points)) < 0.3
    holes = np.where(unknown[:, None], np.nan, normals)
    assert np.array_equal(
        pfh.describe(points, holes, keypoints, RADIUS),
        pfh.describe(points[~unknown], normals[~unknown], keypoints, RADIUS),
    )


@pytest.mark.parametrize("neighbours", [0, 1])
def test_too_few_neighbours_mean_nan(neighbours):
    points = np.array([[0.0, 0.0, 0.0]] * neighbours + [[9.0, 9.0, 9.0], [9.0, 9.0, 9.1]])
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    descriptors = pfh.describe(points, normals, np.array([[0.0, 0.0, 0.0], [9.0, 9.0, 9.0]]), 0.2)
    assert np.isnan(descriptors[0]).all()
    assert descriptors[1].sum() == 100


def test_nothing_has_no_descriptors():
    nothing = np.empty((0, 3))
    assert pfh.describe(nothing, nothing, nothing, 1.0).shape == (0, pfh.LENGTH)
    assert np.isnan(pfh.describe(nothing, nothing, np.zeros((2, 3)), 1.0)).all()
