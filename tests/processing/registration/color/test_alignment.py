"""Alignment by shape and colour: a print holds a bottle that slides, within the bounds that are told."""

import numpy as np
import pytest

from orbitscan.processing.registration.color.alignment import align_by_color, linearize, measure_uncertainty
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.registration.normal_equations import motion
from orbitscan.recorder import poses
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate
from tests.processing.scene import Scene, degrees


@pytest.fixture(scope="module")
def bottle():
    return Scene(first_views(simulate("water_bottle", views=12, paint="print", lamp="camera", color_noise=3), 2))


@pytest.fixture(scope="module")
def colors(bottle):
    return ColorPair.of(bottle.pair(bottle.views[1], bottle.views[0]))


@pytest.mark.parametrize("off_deg", [-8, 3])
def test_a_bottle_turns_back_to_where_its_print_agrees(bottle, colors, off_deg):
    T_0 = bottle.truth[0]
    axis, point = T_0[:3, :3].T @ [0, 0, 1.0], poses.transform(poses.invert(T_0), np.zeros((1, 3)))[0]
    start = poses.turn_about(axis, point, np.radians(off_deg)) @ bottle.T(0, 1)
    refined = align_by_color(colors, start)
    assert refined.converged
    known = measure_uncertainty(colors, refined)
    assert degrees(refined.T_target_source, bottle.T(0, 1)) < known.rotation_bound_deg < 3
    assert colors.pair.measure_uncertainty(refined).rotation_bound_deg > 1.5 * known.rotation_bound_deg


@pytest.mark.parametrize("direction", np.eye(6)[3:5])
def test_rows_tell_how_the_pull_changes(bottle, colors, direction):
    T, center, x = bottle.T(0, 1), colors.pair.center(bottle.T(0, 1)), 5e-4 * direction
    here = linearize(colors, T, center)
    there, back = (linearize(colors, motion(sign * x, center) @ T, center) for sign in (1, -1))
    told = float(x @ (here.rows * here.weights[:, None]).T @ here.rows @ x)
    assert 0.4 * told < (there.pull - back.pull) @ x / 2 < told  # less: part of the gradients is noise


def test_a_start_without_correspondences_stays(colors):
    far = poses.make(np.eye(3), [9.0, 0, 0])
    refined = align_by_color(colors, far)
    assert not refined.converged
    assert measure_uncertainty(colors, refined) is None
