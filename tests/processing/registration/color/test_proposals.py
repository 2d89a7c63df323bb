"""Starts from the corners of colours."""

from dataclasses import replace

import pytest

from orbitscan.processing.registration.color.proposals import propose_by_color
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate
from tests.processing.scene import SETTINGS, Scene


@pytest.fixture(scope="module")
def ball():
    return Scene(first_views(simulate("ball", views=18, paint="print", lamp="camera", color_noise=3), 2))


def test_a_balls_print_proposes_about_how_it_turned(ball):
    source, target = ball.views[1], ball.views[0]
    proposed = propose_by_color(source, target, SETTINGS.pair)
    assert min(ball.pair(source, target).distance(T, ball.T(0, 1)) for T in proposed) < 2


def test_nothing_is_proposed_where_colours_do_not_count_or_are_none(ball):
    source, target = ball.views[1], ball.views[0]
    grey = replace(target, surface=replace(target.surface, colors=None))
    assert not len(propose_by_color(source, target, replace(SETTINGS.pair, color=False)))
    assert not len(propose_by_color(source, grey, SETTINGS.pair))
