"""Colours under a pose: the right one explains them, whatever the lamp; what a lamp does is not taken for paint."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.recorder import poses
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS
from tests.processing.scene import SETTINGS, Scene

WORSE = SETTINGS.pair.covisibility.worse


def scene(tmp_path, name="prism06", views=8, **looks):
    """The first two views of a solid."""
    solid = SOLIDS[name].write(tmp_path) if name in SOLIDS else name
    return Scene(first_views(simulate(solid, views=views, color_noise=3, **looks), 2))


def pair_of(scene):
    return ColorPair.of(scene.pair(scene.views[1], scene.views[0]))


def turned(scene, degrees):
    """The truth, and the object turned about its upright axis besides."""
    T_0 = scene.truth[0]
    axis, point = T_0[:3, :3].T @ [0, 0, 1.0], poses.transform(poses.invert(T_0), np.zeros((1, 3)))[0]
    return poses.turn_about(axis, point, np.radians(degrees)) @ scene.T(0, 1)


@pytest.mark.parametrize(("lamp", "gloss"), [("object", 0.0), ("camera", 0.5), ("room", 0.5)])
def test_a_print_tells_a_prisms_sides_apart_in_any_light(tmp_path, lamp, gloss):
    printed = scene(tmp_path, paint="print", lamp=lamp, gloss=gloss)
    colors = pair_of(printed)
    right, wrong = colors.explain(turned(printed, 0)), colors.explain(turned(printed, -60))
    assert right.usual < 1.5
    assert wrong.worse_than(right) > 10 * WORSE
    for other in (colors.explain_by_lamp(printed.T(0, 1)), colors.explain_by_nothing(printed.T(0, 1))):
        assert other.worse_than(right) > 10 * WORSE


@pytest.mark.parametrize("lamp", ["object", "camera", "room"])
@pytest.mark.parametrize("name", ["prism06", "water_bottle"])
def test_light_on_a_plain_body_tells_nothing(tmp_path, name, lamp):
    plain = scene(tmp_path, name, paint="plain", lamp=lamp)
    colors = pair_of(plain)
    right = colors.explain(turned(plain, 0))
    assert all(abs(colors.explain(turned(plain, by)).worse_than(right)) < WORSE for by in (-60, 60))


def test_a_highlight_could_be_the_lamps(tmp_path):
    shining = scene(tmp_path, "water_bottle", paint="plain", lamp="room", gloss=0.5)
    colors = pair_of(shining)
    assert colors.explain_by_lamp(shining.T(0, 1)).worse_than(colors.explain(np.eye(4))) < WORSE


def test_views_that_hardly_meet_tell_nothing(tmp_path):
    printed = scene(tmp_path, paint="print")
    far = poses.make(np.eye(3), [9.0, 0, 0])
    assert not len(pair_of(printed).explain(far).squares)


def test_views_without_colours_have_none_to_compare(tmp_path):
    printed = scene(tmp_path, paint="print")
    grey = replace(printed.views[0], surface=replace(printed.views[0].surface, colors=None))
    assert ColorPair.of(printed.pair(printed.views[1], grey)) is None
