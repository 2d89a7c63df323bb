"""What surfels meet: the same surface at the right pose, looked-through space before it, nothing beside it."""

import numpy as np
import pytest

from orbitscan.processing.registration.encounter import EncounterSettings, meet
from orbitscan.recorder import poses
from tests.geometry import scan
from tests.processing.scene import Scene

HOW = EncounterSettings()


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=2, step_deg=20))


def at(scene, shift):
    T = poses.make(np.eye(3), np.array(shift) * scene.scale.diameter) @ scene.T(0, 1)
    return meet(T, scene.views[1].judged_surfels, scene.views[0], HOW)


def test_at_the_right_pose_most_meet_a_surface_within_the_noise(scene):
    found = at(scene, [0, 0, 0])
    assert found.met.mean() > 0.6
    assert len(found.residuals) == len(found.variances) == found.met.sum()
    assert np.mean(found.residuals**2 / found.variances) < 1.5
    assert found.in_front.mean() < 0.01


def test_before_the_surface_a_point_is_where_the_sensor_looked_through(scene):
    found = at(scene, [0, 0, -0.3])
    assert found.in_front.mean() > 0.4
    assert not (found.in_front & (found.met | found.unseen)).any()


def test_beside_the_object_what_faces_the_sensor_should_have_been_seen(scene):
    found = at(scene, [2.0, 0, 0])
    T = poses.make(np.eye(3), [2.0 * scene.scale.diameter, 0, 0]) @ scene.T(0, 1)
    surfels = scene.views[1].judged_surfels
    points, normals = poses.transform(T, surfels.points), poses.rotate(T, surfels.normals)
    facing = -(points * normals).sum(axis=1) / np.linalg.norm(points, axis=1) > HOW.unseen_cosine
    assert not found.met.any()
    assert 0.1 < facing.mean() < 0.9
    assert (found.unseen == facing).all()


def test_without_a_sensors_place_only_surfaces_are_met(scene):
    blind = scene.prepare(scene.session.load(0), sensor_origin=None)
    shifted = poses.make(np.eye(3), [0, 0, -0.3 * scene.scale.diameter]) @ scene.T(0, 1)
    found = meet(shifted, scene.views[1].judged_surfels, blind, HOW)
    assert not (found.in_front | found.unseen).any()
