"""Views of different size, which no pose makes up for."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.competition import verify_scale
from orbitscan.recorder import poses
from tests.geometry import plane, scan
from tests.processing.scene import Scene, edge


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=2, step_deg=20))


def measured(scene, size):
    """The first two views aligned, the second one so many times as large."""
    target, view = scene.views[0], scene.session.load(1)
    source = scene.prepare(replace(view, points=(size * view.points).astype(np.float32)))
    pair = scene.pair(source, target)
    T = scene.T(0, 1)
    middle = source.surface.surfels.points.mean(axis=0)
    aligned = pair.align(T @ poses.make(np.eye(3), middle / size - middle))
    return pair, aligned.T_target_source


@pytest.mark.parametrize("size", [0.96, 0.97, 1.03, 1.04])
def test_it_is_measured_from_an_aligned_pose(scene, size):
    pair, T = measured(scene, size)
    found = pair.measure_scale(T)
    assert found.is_certain
    assert found.larger == pytest.approx(size - 1, abs=0.002)
    judged = verify_scale(pair, edge(1, 0, T))
    assert judged.status == "inconsistent"
    assert f"{100 * abs(size - 1):.1f} % {'larger' if size > 1 else 'smaller'}" in judged.note


@pytest.mark.parametrize("size", [0.99, 1.0, 1.02])
def test_what_a_sensor_may_be_off_here_and_there_is_no_other_size(scene, size):
    pair, T = measured(scene, size)
    assert pair.measure_scale(T).larger == pytest.approx(size - 1, abs=0.002)
    assert not pair.measure_scale(T).is_certain
    assert verify_scale(pair, edge(1, 0, T)).status == "ok"


def test_a_plane_has_no_size():
    scene = Scene(scan(n_views=2, surface=plane, step_deg=10))
    found = scene.pair(scene.views[1], scene.views[0]).measure_scale(scene.T(0, 1))
    assert found is None or not found.is_certain


def test_views_that_do_not_meet_tell_nothing(scene):
    far = poses.make(np.eye(3), [9.0, 0, 0])
    assert scene.pair(scene.views[1], scene.views[0]).measure_scale(far) is None
