"""Starts: among those that single correspondences propose is the right one, and a few points tell it from most."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.hypotheses import StartSettings, propose, screen
from orbitscan.recorder import poses
from tests.geometry import random_pose, scan
from tests.processing.scene import Scene, degrees

HOW = StartSettings()


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=2, step_deg=20))


def turned(scene, seed):
    """The second view from a sensor frame turned at random, and its true pose in the first."""
    T = random_pose(np.random.default_rng(seed), shift=0)
    view = scene.session.load(1)
    prepared = scene.prepare(replace(view, points=poses.transform(T, view.points).astype(np.float32)))
    return prepared, scene.T(0, 1) @ poses.invert(T)


def displaced(T, source):
    """How far a pose (or poses) puts the middle of the source [m]."""
    return T[..., :3, :3] @ source.coarse_surfels.points.mean(axis=0) + T[..., :3, 3]


@pytest.mark.parametrize("seed", range(4))
def test_a_right_start_is_proposed_for_a_view_turned_at_random(scene, seed):
    source, T = turned(scene, seed)
    found = propose(source, scene.views[0], scene.correspond(source, scene.views[0]).indices, HOW)
    near = [
        degrees(start, T) < 12 and np.linalg.norm(displaced(start, source) - displaced(T, source)) < 0.02
        for start in found
    ]
    assert any(near[:3])
    assert len(found) <= HOW.most


def test_starts_are_rigid_and_differ(scene):
    source, target = scene.views[1], scene.views[0]
    found = propose(source, target, scene.correspond(source, target).indices, HOW)
    assert np.allclose(found[:, :3, :3] @ found[:, :3, :3].transpose(0, 2, 1), np.eye(3), atol=1e-6)
    assert np.allclose(np.linalg.det(found[:, :3, :3]), 1)
    places = displaced(found, source)
    for i in range(len(found)):
        for j in range(i):
            apart = np.linalg.norm(places[i] - places[j]) / source.scale.diameter
            assert degrees(found[i], found[j]) > HOW.distinct_deg or apart > HOW.distinct_shift


def test_one_right_correspondence_among_wrong_ones_is_enough(scene):
    """The strength of whole frames: a consensus set of three would never be found."""
    source, target = scene.views[1], scene.views[0]
    T, rng = scene.T(0, 1), np.random.default_rng(0)
    places = poses.transform(T, source.keypoints)
    distance = np.linalg.norm(places[:, None] - target.keypoints, axis=2)
    turns = np.einsum("mki,nkj->mnij", target.frames, source.frames)
    angle = np.linalg.norm(turns - T[:3, :3], axis=(2, 3)).T
    angle[distance > 0.003] = np.inf
    right = np.unravel_index(np.nanargmin(angle), angle.shape)
    wrong = rng.integers((len(source.keypoints), len(target.keypoints)), size=(60, 2))
    found = propose(source, target, np.vstack([wrong, [right]]), HOW)
    assert min(degrees(start, T) for start in found) < 10


def test_no_matches_propose_nothing(scene):
    found = propose(scene.views[1], scene.views[0], np.empty((0, 2), np.int64), HOW)
    assert found.shape == (0, 4, 4)


def test_a_few_points_prefer_the_truth(scene):
    source, target = scene.views[1], scene.views[0]
    T, rng = scene.T(0, 1), np.random.default_rng(0)
    middle = displaced(T, source)
    others = []
    for _ in range(300):  # the object where it is, but turned and moved
        off = random_pose(rng, shift=0.01)
        others.append(poses.make(np.eye(3), middle) @ off @ poses.make(np.eye(3), -middle) @ T)
    away = np.array([degrees(other, T) > 15 for other in others])
    score = screen(np.array([T, *others]), source, target, HOW)
    assert score.max() <= 1
    assert score[0] > 0.9
    assert score[0] > score[1:][away].max()
    assert np.median(score[1:]) < 0.5
    nowhere = screen(poses.make(np.eye(3), [5.0, 0, 0])[None], source, target, HOW)
    assert nowhere[0] < 0


def test_without_a_sensor_only_the_surface_counts(scene):
    source, target = (scene.prepare(scene.session.load(i), sensor_origin=None) for i in (1, 0))
    assert target.range_image is None
    score = screen(np.array([scene.T(0, 1), poses.make(np.eye(3), [5.0, 0, 0])]), source, target, HOW)
    assert score[0] > 0.9
    assert score[1] == 0
