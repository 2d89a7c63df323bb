"""What all pairs say of each view: what speaks against it, and how well it is known."""

import numpy as np
import pytest

from orbitscan.processing.reconstruction.view_judgement import bound_centers, judge_views
from orbitscan.processing.results.estimates import ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses
from tests.processing.scene import edge

DIAMETER = 0.2
CENTER = np.array([0.0, 0, 1.0])  # of the object, in every view


def around(angle_deg):
    """A camera's pose T_0_i so far round the object."""
    return poses.turn_about(np.array([0.0, 1, 0]), CENTER, np.radians(angle_deg))


def pair(source, target, angles, off_deg=0.0):
    turn = poses.invert(around(angles[target])) @ around(angles[source] + off_deg)
    return edge(source, target, turn, CENTER)


def judged(angles, pairs, contradicting=()):
    views = [ViewEstimate(i, Status.OK, around(angle)) for i, angle in enumerate(angles)]
    return judge_views(views, pairs, 0, DIAMETER, contradicting)


def chain(angles):
    return [pair(i, i - 1, angles) for i in range(1, len(angles))]


def statuses(views):
    return [view.status.value for view in views]


def test_views_that_one_pair_holds_are_not_ok_where_another_says_otherwise():
    angles = [0, 30, 60, 90]
    against = [pair(3, 1, angles, off_deg=60)]
    found = judged(angles, chain(angles), against)
    assert statuses(found) == ["ok", "ok", "inconsistent", "inconsistent"]
    assert "another pair" in found[2].note
    held_twice = [*chain(angles), pair(2, 0, angles), pair(3, 0, angles)]
    assert statuses(judged(angles, held_twice, against)) == ["ok"] * 4


def test_a_view_that_slips_from_an_even_turn_is_not_ok():
    angles = [20.0 * i for i in range(9)]
    angles[4] += 9
    found = judged(angles, chain(angles))
    assert [view.view for view in found if view.status != "ok"] == [4]
    assert "9.0°" in found[4].note


@pytest.mark.parametrize("slip", [4.0, 0.0])
def test_a_small_slip_is_none(slip):
    angles = [20.0 * i for i in range(9)]
    angles[4] += slip
    assert statuses(judged(angles, chain(angles))) == ["ok"] * 9


def test_a_pairs_bound_is_at_the_objects_middle():
    """What is turned wrongly shifts what is far from where it is turned about."""
    near = chain([0, 30])
    aside = edge(1, 0, near[0].T_target_source, CENTER + np.array([1.0, 0, 0]), status="ambiguous")
    same, moved = bound_centers([*near, aside], judged([0, 30], near))
    assert moved.center_bound_m > 2 * same.center_bound_m


def test_where_no_view_is_ok_bounds_stay_as_they_are():
    lost = [ViewEstimate(0, Status.OK, np.eye(4)), ViewEstimate(1, Status.AMBIGUOUS, around(30))]
    pairs = chain([0, 30])
    assert bound_centers(pairs, lost) == pairs
