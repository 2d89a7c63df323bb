"""ESF against PCL's, which are random samples too: as far apart as two seeds; and what holds on any cloud."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from orbitscan.processing.features import esf

RADIUS = 0.04
REFERENCE = Path(__file__).parents[2] / "reference"


@pytest.fixture(scope="module")
def clouds():
    """Five patches and the whole view."""
    view = np.load(REFERENCE / "pcl_robot_view.npz")
    points = view["points"].astype(float)
    tree = cKDTree(points)
    return [points[tree.query_ball_point(keypoint, RADIUS)] for keypoint in view["keypoints"][:5]] + [points]


@pytest.fixture(scope="module")
def ours(clouds):
    """(6, 4, 640): of each cloud with four seeds."""
    return np.array([[esf.describe(cloud, seed) for seed in range(4)] for cloud in clouds])


@pytest.fixture(scope="module")
def pcls():
    reference = np.load(REFERENCE / "pcl_descriptors.npz")
    return np.vstack([reference["esf_patches"][:5], reference["esf_view"]])


def distance(a, b):
    return float(np.abs(a - b).sum())


def test_pcls_sample_is_as_far_as_another_seed(ours, pcls):
    own = [distance(*pair) for seeds in ours for pair in combinations(seeds, 2)]
    from_pcl = [distance(one, pcl) for seeds, pcl in zip(ours, pcls, strict=True) for one in seeds]
    assert np.mean(from_pcl) < 1.1 * np.mean(own)
    assert np.max(from_pcl) < 1.3 * np.max(own)


def test_every_histogram_holds_its_share(ours, pcls):
    blocks = ours.reshape(6, 4, 10, 64).sum(axis=3).mean(axis=1)
    assert np.abs(blocks - pcls.reshape(6, 10, 64).sum(axis=2)).max() < 0.005


def test_other_clouds_are_far(ours, pcls):
    own = max(distance(*pair) for seeds in ours for pair in combinations(seeds, 2))
    others = [distance(ours[i, 0], pcls[j]) for i in range(6) for j in range(6) if i != j]
    assert min(others) > 2 * own


def test_a_seed_decides_all(clouds):
    first = esf.describe(clouds[0], 7)
    assert np.array_equal(first, esf.describe(clouds[0], np.random.default_rng(7)))
    assert not np.array_equal(first, esf.describe(clouds[0], 8))
    assert first.sum() == pytest.approx(1)


def test_place_and_scale_do_not_show_and_turns_hardly(clouds, ours):
    spread = max(distance(*pair) for pair in combinations(ours[0], 2))
    assert distance(esf.describe(8 * clouds[0] + 2, 0), ours[0, 0]) < 0.1 * spread
    R = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    assert distance(esf.describe(clouds[0] @ R.T, 0), ours[0, 0]) < 2 * spread


def test_sides_run_inside_a_ball_and_outside_two_specks():
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(50_000, 3))
    ball *= (rng.random((50_000, 1)) ** (1 / 3)) / np.linalg.norm(ball, axis=1, keepdims=True)
    inside, outside, _, _ = sides(esf.describe(ball, 0))
    assert inside > 20 * outside
    specks = rng.normal(scale=0.01, size=(2000, 3)) + np.where(np.arange(2000) % 2, 1.0, -1.0)[:, None]
    inside, outside, mixed, _ = sides(esf.describe(specks, 0))
    assert outside + inside > 5 * mixed
    assert outside > 0.1


def sides(descriptor):
    return descriptor.reshape(10, 64).sum(axis=1)[6:]


@pytest.mark.parametrize(
    "points",
    [np.empty((0, 3)), np.eye(3)[:2], np.ones((10, 3)), np.linspace(0, 1, 50)[:, None] * [[1.0, 2.0, 3.0]]],
    ids=["nothing", "two points", "one place", "a line"],
)
def test_no_triangle_means_nan(points):
    descriptor = esf.describe(points, 0)
    assert descriptor.shape == (esf.LENGTH,)
    assert np.isnan(descriptor).all()
