"""Corners of colours: found again in another view of a body that has no corner of its own."""

import numpy as np
import pytest

from orbitscan.processing.registration.matching import MatchSettings, match
from orbitscan.recorder import poses
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate
from tests.processing.scene import Scene


@pytest.fixture(scope="module")
def printed():
    return Scene(first_views(simulate("ball", views=18, paint="print", color_noise=3), 2))


def test_a_balls_print_has_corners_that_are_found_again(printed):
    source, target = (view.by_color for view in reversed(printed.views))
    assert min(len(source.keypoints), len(target.keypoints)) > 10
    matches = match(source.descriptors, target.descriptors, MatchSettings())
    moved = poses.transform(printed.T(0, 1), source.keypoints[matches[:, 0]])
    off = np.linalg.norm(moved - target.keypoints[matches[:, 1]], axis=1)
    assert np.sum(off < 4 * printed.scale.working) >= 5


def test_frames_are_rotations_and_descriptors_unit_vectors(printed):
    view = printed.views[0].by_color
    assert view.frames @ view.frames.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(3), (len(view.frames), 1, 1)))
    assert np.linalg.det(view.frames) == pytest.approx(1)
    assert np.linalg.norm(view.descriptors, axis=1) == pytest.approx(1)


def test_what_is_plain_has_none():
    plain = Scene(first_views(simulate("ball", views=18, paint="plain", lamp="camera", color_noise=3), 1))
    assert not len(plain.views[0].by_color.keypoints)
