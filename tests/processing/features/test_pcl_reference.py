"""Normals, ISS and SHOT against PCL's values on one view, and what holds on any view."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.processing.features.keypoints import KeypointSettings, detect_keypoints
from orbitscan.processing.features.shot import LENGTH, describe
from orbitscan.processing.surface.normals import estimate_normals


@pytest.fixture(scope="module")
def reference():
    return np.load(Path(__file__).parents[2] / "reference" / "pcl_robot_view.npz")


def test_normals_are_pcls(reference):
    normals = estimate_normals(reference["points"], 0.01, np.zeros(3))
    cosine = np.einsum("ni,ni->n", normals, reference["normals"])
    assert np.abs(cosine).min() > 1 - 1e-6
    # Edge-on patches, whose side rounding decides, aside.
    edge_on = np.abs(np.einsum("ni,ni->n", normals, reference["points"])) < 1e-7
    assert (cosine[~edge_on] > 0).all()
    assert edge_on.mean() < 1e-3


def test_iss_keypoints_are_pcls_exactly(reference):
    points = reference["points"]
    indices = detect_keypoints(points, 0.012, 0.008, KeypointSettings())
    assert {tuple(p) for p in points[indices]} == {tuple(p) for p in reference["keypoints"]}


def test_keypoints_are_capped_at_the_most_salient(reference):
    points = reference["points"]
    everything = detect_keypoints(points, 0.012, 0.008, KeypointSettings())
    few = detect_keypoints(points, 0.012, 0.008, KeypointSettings(at_most=20))
    assert few.tolist() == everything[:20].tolist()


def test_shot_is_pcls_within_a_millionth(reference):
    keypoints = reference["keypoints"][reference["picked"]]
    descriptors, frames = describe(reference["points"], reference["normals"], keypoints, 0.04)
    assert np.abs(frames - reference["frames"]).max() < 1e-5
    assert np.abs(descriptors - reference["shot"]).max() < 1e-6


def test_shot_does_not_change_when_the_view_moves(reference):
    R = Rotation.from_euler("xyz", [0.4, -1.1, 2.0]).as_matrix()
    points, normals = reference["points"].astype(float), reference["normals"].astype(float)
    keypoints = reference["keypoints"][::40].astype(float)
    before, _ = describe(points, normals, keypoints, 0.04)
    after, _ = describe(points @ R.T + 1, normals @ R.T, keypoints @ R.T + 1, 0.04)
    distance = np.linalg.norm(before - after, axis=1)
    assert np.median(distance) < 1e-3


def test_descriptors_have_unit_length_and_no_frame_means_nan():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.random((500, 2)), np.zeros(500)])
    points[:, 2] = 0.05 * np.sin(9 * points[:, 0])
    lonely = np.array([[9.0, 9.0, 9.0]])
    cloud = np.vstack([points, lonely])
    sensor = np.array([0.0, 0.0, 5.0])
    normals = estimate_normals(cloud, 0.1, sensor)
    descriptors, frames = describe(cloud, normals, np.vstack([points[:10], lonely]), 0.3)
    assert descriptors.shape == (11, LENGTH)
    assert np.allclose(np.linalg.norm(descriptors[:10], axis=1), 1, atol=1e-6)
    assert np.isnan(descriptors[10]).all()
    assert np.isnan(frames[10]).all()
    assert np.isnan(normals[500]).all()
    assert np.nanmin(np.einsum("ni,ni->n", normals[:500], sensor - points)) >= 0


def test_normals_point_outwards_where_the_sensor_is_unknown():
    rng = np.random.default_rng(0)
    sphere = rng.normal(size=(3000, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    normals = estimate_normals(sphere + 4, 0.3, None)
    assert (np.einsum("ni,ni->n", normals, sphere) > 0.95).all()
