"""Which poses colours are asked about: a prism's sides, every turn of a bottle, the best first."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.color.candidates import approach, choose_likely, look_everywhere, tell_along
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.results.estimates import Freedom, Symmetry
from orbitscan.recorder import poses
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS
from tests.processing.scene import Scene, degrees, edge


def about(scene):
    """The object's upright axis in the first view's frame, and a point on it."""
    T_0 = scene.truth[0]
    return T_0[2, :3], poses.transform(poses.invert(T_0), np.zeros((1, 3)))[0]


def look(scene, T, **fields):
    """The colours of the first two views, and the poses that are looked at besides T and what is open about it."""
    colors = ColorPair.of(scene.pair(scene.views[1], scene.views[0]))
    return colors, look_everywhere(colors, replace(edge(1, 0, T), **fields))


@pytest.fixture(scope="module")
def prism(tmp_path_factory):
    solid = SOLIDS["prism06"].write(tmp_path_factory.mktemp("solid"))
    return Scene(first_views(simulate(solid, views=8, paint="print", color_noise=3), 2))


@pytest.fixture(scope="module")
def bottle():
    return Scene(first_views(simulate("water_bottle", views=12, paint="print", color_noise=3), 2))


def test_of_a_prisms_sides_the_right_one_comes_first(prism):
    axis, point = about(prism)
    wrong = poses.turn_about(axis, point, np.radians(-60)) @ prism.T(0, 1)
    colors, found = look(prism, wrong, symmetries=(Symmetry(axis, point, 6),))
    assert len(found) >= 6
    likely, others = choose_likely(colors, found)
    assert degrees(likely[0], prism.T(0, 1)) < 1
    assert sum(degrees(T, prism.T(0, 1)) > 50 for T in others) >= 3


def test_a_free_turn_is_looked_along(bottle):
    axis, point = about(bottle)
    off = poses.turn_about(axis, point, np.radians(100)) @ bottle.T(0, 1)
    _, found = look(bottle, off, freedoms=(Freedom("turn", axis, point),))
    assert degrees(found[0][0], bottle.T(0, 1)) < 5


def test_a_free_shift_is_looked_along(bottle):
    axis, point = about(bottle)
    off = poses.make(np.eye(3), 0.12 * bottle.scale.diameter * axis) @ bottle.T(0, 1)
    _, found = look(bottle, off, freedoms=(Freedom("shift", axis, point),))
    pair = bottle.pair(bottle.views[1], bottle.views[0])
    assert pair.distance(found[0][0], bottle.T(0, 1)) < 0.6


def test_where_nothing_shows_contrast_hardly_any_is_likely():
    plain = Scene(first_views(simulate("water_bottle", views=12, paint="plain", lamp="camera", color_noise=3), 2))
    axis, point = about(plain)
    colors, found = look(plain, plain.T(0, 1), freedoms=(Freedom("turn", axis, point),))
    assert len(choose_likely(colors, found)[0]) <= 1 < len(found)


def banded(scene):
    """The scene with bands about its upright axis, which tell heights and no turn."""
    views = []
    for k, view in enumerate(scene.views):
        height = poses.transform(scene.truth[k], view.surface.points)[:, 2] / scene.scale.diameter
        colors = np.where((height * 8 % 2 < 1)[:, None], [[200, 40, 40]], [[60, 60, 160]]).astype(np.uint8)
        views.append(replace(view, surface=replace(view.surface, colors=colors)))
    return ColorPair.of(scene.pair(views[1], views[0]))


def test_a_print_may_hold_a_turn_and_bands_may_not(bottle):
    axis, point = about(bottle)
    turn, off = Freedom("turn", axis, point), poses.turn_about(axis, point, np.radians(100)) @ bottle.T(0, 1)
    assert tell_along(ColorPair.of(bottle.pair(bottle.views[1], bottle.views[0])), off, turn)
    assert not tell_along(banded(bottle), off, turn)
    assert tell_along(banded(bottle), bottle.T(0, 1), Freedom("shift", axis, point))


def test_likely_poses_are_approached_and_those_of_one_end_are_one(bottle):
    axis, point = about(bottle)
    near = [poses.turn_about(axis, point, np.radians(angle)) @ bottle.T(0, 1) for angle in (-4, 3, 5)]
    (end,) = approach(ColorPair.of(bottle.pair(bottle.views[1], bottle.views[0])), near, free=True)
    assert degrees(end, bottle.T(0, 1)) < 1
    apart = [poses.turn_about(axis, point, np.radians(angle)) @ bottle.T(0, 1) for angle in (0, 40, 80)]
    assert approach(banded(bottle), apart, free=True) == []
    assert len(approach(banded(bottle), apart, free=False)) == 3
