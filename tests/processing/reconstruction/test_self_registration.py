"""The object registered with itself: what all views show together has the solid's order, or none."""

import numpy as np
import pytest

from orbitscan.processing.reconstruction.self_registration import find_self_symmetries, tell_by_color
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.results.estimates import Symmetry
from orbitscan.recorder import poses
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS
from tests.processing.scene import SETTINGS, Scene


def found(session, views=None):
    scene = Scene(session)
    T_0 = {view: scene.T(0, view) for view in views or range(len(scene.views))}
    usual = scene.pair(scene.views[1], scene.views[0]).explain(scene.T(0, 1))
    return find_self_symmetries(scene, T_0, [], usual, SETTINGS.pair)


@pytest.mark.parametrize(("name", "order"), [("box", 2), ("carton", 4), ("prism03", 3)])
def test_a_solid_has_its_order_about_its_axis(tmp_path, name, order):
    session = simulate(SOLIDS[name].write(tmp_path), views=8)
    up = poses.invert(session.truth()[0])[:3, 2]
    upright = [s for s in found(session) if abs(s.axis @ up) > np.cos(np.radians(2))]
    assert max(symmetry.order for symmetry in upright) == order


def test_what_has_no_symmetry_has_none():
    assert found(simulate("robot", views=8, focal=300)) == []


def test_two_views_are_too_few(tmp_path):
    assert found(simulate(SOLIDS["cube"].write(tmp_path), views=8), [0, 1]) == []


@pytest.mark.parametrize(("paint", "orders"), [("print", {4: True}), ("plain", {4: False})])
def test_colours_tell_the_sides_of_a_printed_carton_apart(tmp_path, paint, orders):
    scene = Scene(simulate(SOLIDS["carton"].write(tmp_path), views=8, paint=paint, lamp="camera", color_noise=3))
    T_0 = {view: scene.T(0, view) for view in range(8)}
    usual = ColorPair.of(scene.pair(scene.views[1], scene.views[0])).explain(scene.T(0, 1))
    upright = Symmetry(scene.truth[0][2, :3], poses.transform(poses.invert(scene.truth[0]), np.zeros((1, 3)))[0], 4)
    told = tell_by_color(scene, T_0, [upright], usual, SETTINGS.pair)
    assert {symmetry.order: symmetry.told_by_color for symmetry in told} == orders
    assert tell_by_color(scene, T_0, [upright], None, SETTINGS.pair) == [upright]
