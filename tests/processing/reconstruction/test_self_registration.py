"""The object registered with itself: what all views show together has the solid's order, or none."""

import numpy as np
import pytest

from orbitscan.processing.reconstruction.self_registration import find_self_symmetries
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
