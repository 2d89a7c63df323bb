"""The turntable behind poses: its axis, its step, and the one view that slipped."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.processing.reconstruction.turntable import TurntableSettings, find_slips, fit_turntable
from orbitscan.recorder import poses
from tests.geometry import random_pose

HOW = TurntableSettings()


def unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def turn(axis, point, angle_deg):
    return poses.turn_about(axis, point, np.radians(angle_deg))


def turned(axis, point, step_deg, views):
    """T_0_i of a camera that goes round an axis, in the frame of the first view."""
    return {i: turn(axis, point, step_deg * (i - views[0])) for i in views}


@given(st.integers(0, 10**6), st.floats(2.0, 100.0))
def test_exact_poses_give_the_axis_the_point_and_the_step(seed, step_deg):
    rng = np.random.default_rng(seed)
    axis, point = unit(rng), rng.normal(size=3)
    found = fit_turntable(turned(axis, point, step_deg, range(8)), HOW)
    assert np.allclose(found.axis, axis, atol=1e-6)
    assert np.linalg.norm(np.cross(found.point - point, axis)) < 1e-6
    assert found.step_deg == pytest.approx(step_deg, abs=1e-6)
    assert [d.view for d in found.deviations] == list(range(8))
    for deviation in found.deviations:
        assert abs(deviation.slip_deg) < 1e-5
        assert deviation.wobble_deg < 1e-5
        assert deviation.shift_m < 1e-6


def test_the_axis_turns_by_the_right_hand_whichever_way_the_table_goes():
    axis, point = unit(np.random.default_rng(0)), np.ones(3)
    there, back = (fit_turntable(turned(axis, point, step, range(6)), HOW) for step in (20, -20))
    assert np.allclose(there.axis, axis)
    assert np.allclose(back.axis, -axis)
    assert back.step_deg == pytest.approx(20)


@pytest.mark.parametrize("view", [1, 4, 17])
def test_a_slip_of_one_view_shows_at_that_view(view):
    axis, point = unit(np.random.default_rng(1)), np.array([0, 0.1, 0.9])
    T_0 = turned(axis, point, 20, range(18))
    T_0[view] = turn(axis, point, 20 * view + 1.5)
    found = fit_turntable(T_0, HOW)
    slips = {d.view: d.slip_deg for d in found.deviations}
    assert slips.pop(view) == pytest.approx(1.5, abs=1e-3)
    assert max(map(abs, slips.values())) < 1e-3
    assert found.step_deg == pytest.approx(20, abs=1e-6)


def test_a_slip_that_stays_shows_at_all_views_after_it():
    axis, point = unit(np.random.default_rng(1)), np.array([0, 0.1, 0.9])
    T_0 = {i: turn(axis, point, 10 * i + (2 if i >= 8 else 0)) for i in range(11)}
    slips = [d.slip_deg for d in fit_turntable(T_0, HOW).deviations]
    assert np.allclose(slips, [0] * 8 + [2] * 3, atol=1e-3)


def test_wobble_and_shift_show_where_they_are():
    axis, point = np.array([0, 1.0, 0]), np.array([0, 0, 1.0])
    T_0 = turned(axis, point, 20, range(18))
    T_0[5] = T_0[5] @ turn(np.array([1.0, 0, 0]), np.array([0, 0, 1.0]), 3)
    T_0[9] = poses.make(np.eye(3), [0, 0.01, 0]) @ T_0[9]
    found = fit_turntable(T_0, HOW)
    wobble = {d.view: d.wobble_deg for d in found.deviations}
    shift = {d.view: d.shift_m for d in found.deviations}
    assert max(wobble, key=wobble.get) == 5
    assert wobble[5] == pytest.approx(3, abs=0.4)
    assert max(shift, key=shift.get) == 9
    assert shift[9] == pytest.approx(0.01, abs=0.002)


def test_missing_views_do_not_change_the_step():
    axis, point = unit(np.random.default_rng(2)), np.ones(3)
    found = fit_turntable(turned(axis, point, 15, [2, 3, 5, 6, 9, 11]), HOW)
    assert found.step_deg == pytest.approx(15)
    assert np.abs([d.slip_deg for d in found.deviations]).max() < 1e-5


def test_noise_moves_the_axis_little():
    rng = np.random.default_rng(3)
    axis, point = unit(rng), np.array([0, 0.1, 0.9])
    about, back = poses.make(np.eye(3), point), poses.make(np.eye(3), -point)
    T_0 = {i: T @ about @ random_pose(rng, 0.01, 0.0005) @ back for i, T in turned(axis, point, 20, range(18)).items()}
    found = fit_turntable(T_0, HOW)
    assert np.degrees(np.arccos(found.axis @ axis)) < 0.3
    assert found.step_deg == pytest.approx(20, abs=0.3)


@pytest.mark.parametrize("seed", range(5))
def test_random_poses_are_no_turntable(seed):
    rng = np.random.default_rng(seed)
    T_0 = {0: np.eye(4)} | {i: random_pose(rng) for i in range(1, 10)}
    assert fit_turntable(T_0, HOW) is None


def test_too_few_views_or_too_small_a_turn_are_no_turntable():
    axis, point = unit(np.random.default_rng(4)), np.ones(3)
    assert fit_turntable({}, HOW) is None
    assert fit_turntable(turned(axis, point, 30, range(2)), HOW) is None
    assert fit_turntable(turned(axis, point, 30, range(3)), HOW) is not None
    assert fit_turntable(turned(axis, point, 1, range(5)), HOW) is None
    assert fit_turntable({i: np.eye(4) for i in range(5)}, HOW) is None


def at(angles_deg):
    """T_0_i of a camera that has gone so far round an axis."""
    axis, point = unit(np.random.default_rng(5)), np.array([0, 0.1, 0.9])
    return {i: turn(axis, point, angle - angles_deg[0]) for i, angle in enumerate(angles_deg)}


def test_a_view_that_slips_from_an_even_turn_is_told():
    angles = [20.0 * i for i in range(12)]
    angles[7] += 60
    assert find_slips(at(angles)) == pytest.approx({7: 60}, abs=0.1)


@pytest.mark.parametrize(
    "angles",
    [
        [20.0 * i + 15 * (i >= 6) for i in range(12)],  # the turntable was moved once
        [*(40.0 * i for i in range(9)), *(40.0 * i + 20 for i in range(9))],  # a second turn, between the first one's
        [0, 13, 41, 55, 83, 97, 130, 141, 170],  # by hand
        [20.0 * i + 4 * (i == 3) for i in range(12)],
        [0, 20, 47, 60],  # too few to tell what is even
    ],
    ids=["moved once", "two turns", "by hand", "a little", "few"],
)
def test_what_else_is_uneven_is_no_slip(angles):
    assert find_slips(at(angles)) == {}
