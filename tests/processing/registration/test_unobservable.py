"""Free motions: taken out of errors and information whole, and nothing else with them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.unobservable import (
    direction,
    hold,
    release,
    same_freedom,
    take_out,
    turn_by_step,
)
from orbitscan.processing.results.estimates import Freedom
from orbitscan.recorder import poses
from tests.geometry import random_pose
from tests.processing.scene import degrees

seeds = st.integers(0, 10**6)


def unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def close(A, B):
    return np.allclose(A, B, atol=1e-9)


@given(seeds)
def test_a_declared_turn_is_taken_out_whole_and_nothing_else(seed):
    rng = np.random.default_rng(seed)
    axis, point, center = unit(rng), rng.normal(size=3), rng.normal(size=3)
    freedom = Freedom("turn", axis, point)
    assert close(take_out(poses.turn_about(axis, point, rng.uniform(-3, 3)), [freedom], center), np.eye(4))
    swing = np.cross(axis, unit(rng))
    rest = poses.turn_about(swing / np.linalg.norm(swing), rng.normal(size=3), rng.uniform(-2, 2))  # across the axis
    rest = poses.make(np.eye(3), rng.normal(size=3)) @ rest
    assert close(take_out(rest, [freedom], center), rest)
    assert close(take_out(poses.turn_about(axis, point, rng.uniform(-3, 3)) @ rest, [freedom], center), rest)


@given(seeds)
def test_a_declared_shift_is_taken_out_whole_and_nothing_else(seed):
    rng = np.random.default_rng(seed)
    axis, center = unit(rng), rng.normal(size=3)
    freedom = Freedom("shift", axis, rng.normal(size=3))
    along = poses.make(np.eye(3), rng.normal() * axis)
    assert close(take_out(along, [freedom], center), np.eye(4))
    across = np.cross(axis, rng.normal(size=3))
    rest = poses.make(np.eye(3), across) @ poses.turn_about(unit(rng), center, rng.uniform(-3, 3))
    assert close(take_out(rest, [freedom], center), rest)
    assert close(take_out(along @ rest, [freedom], center), rest)


@given(seeds, st.sampled_from(["turn", "shift"]))
def test_what_is_left_is_never_larger_and_stays(seed, kind):
    rng = np.random.default_rng(seed)
    center = rng.normal(size=3)
    freedom = Freedom(kind, unit(rng), rng.normal(size=3))
    D = random_pose(rng)
    left = take_out(D, [freedom], center)
    assert degrees(left, np.eye(4)) <= degrees(D, np.eye(4)) + 1e-5
    assert close(take_out(left, [freedom], center), left)
    assert close(take_out(D, [], center), D)


@given(seeds)
def test_all_turns_about_a_middle_are_free_where_three_are(seed):
    rng = np.random.default_rng(seed)
    middle, axes = rng.normal(size=3), Rotation.random(rng=rng).as_matrix()
    D = poses.turn_about(unit(rng), middle, rng.uniform(-3, 3))
    left = take_out(D, [Freedom("turn", axis, middle) for axis in axes], middle + 0.1)
    assert np.abs(left - np.eye(4)).max() < 1e-6


@given(seeds)
def test_a_screw_along_a_cylinder_is_a_turn_and_a_shift(seed):
    rng = np.random.default_rng(seed)
    axis, point = unit(rng), rng.normal(size=3)
    D = poses.make(np.eye(3), rng.normal() * axis) @ poses.turn_about(axis, point, rng.uniform(-3, 3))
    both = [Freedom("turn", axis, point), Freedom("shift", axis, point)]
    assert close(take_out(D, both, rng.normal(size=3)), np.eye(4))
    assert close(take_out(D, both[::-1], rng.normal(size=3)), np.eye(4))


def test_one_free_motion_seen_twice_is_one():
    z = np.array([0.0, 0, 1])
    a, near = Freedom("turn", z, np.zeros(3)), (10.0, 0.02)
    assert same_freedom(a, Freedom("turn", -z, np.array([0, 0.01, 7.0])), *near)
    assert not same_freedom(a, Freedom("shift", z, np.zeros(3)), *near)
    assert not same_freedom(a, Freedom("turn", z, np.array([0, 0.05, 0])), *near)
    assert not same_freedom(a, Freedom("turn", np.array([0, np.sin(0.3), np.cos(0.3)]), np.zeros(3)), *near)
    assert same_freedom(Freedom("shift", z, np.zeros(3)), Freedom("shift", z, np.ones(3)), *near)


@given(seeds, st.sampled_from(["turn", "shift"]))
def test_information_is_released_along_a_freedom_only_and_can_be_held_there(seed, kind):
    rng = np.random.default_rng(seed)
    B = rng.normal(size=(6, 6))
    A, center = B @ B.T + np.eye(6), rng.normal(size=3)
    freedom = Freedom(kind, unit(rng), rng.normal(size=3))
    v = direction(freedom, center)
    released, held = release(A, center, freedom), hold(A, center, freedom, 0.01)
    assert np.allclose(released @ v, 0, atol=1e-8)
    assert np.linalg.eigvalsh(released).min() > -1e-8
    assert v @ held @ v == pytest.approx(1 / 0.01**2)
    # With the motion free, what is known of the others is what is left when it takes whatever value fits best.
    x = rng.normal(size=6)
    best = x - (v @ A @ x) / (v @ A @ v) * v
    assert x @ released @ x == pytest.approx(best @ A @ best)


@given(seeds)
def test_the_direction_of_a_turn_is_its_small_motion(seed):
    rng = np.random.default_rng(seed)
    axis, point, center = unit(rng), rng.normal(size=3), rng.normal(size=3)
    v, D = direction(Freedom("turn", axis, point), center), poses.turn_about(axis, point, 1e-6)
    assert np.allclose(v[:3], axis)
    assert np.allclose((poses.transform(D, center[None])[0] - center) / 1e-6, v[3:], atol=1e-5)
    assert np.allclose(direction(Freedom("shift", axis, point), center), [0, 0, 0, *axis])


def test_how_near_two_axes_must_be_is_told_by_the_object():
    """Two axes a centimetre apart are one in a chair and two in a coin."""
    z = np.array([0.0, 0, 1])
    a, b = Freedom("turn", z, np.zeros(3)), Freedom("turn", z, np.array([0.01, 0, 0]))
    assert same_freedom(a, b, 10.0, 0.1)
    assert not same_freedom(a, b, 10.0, 0.002)


@pytest.mark.parametrize("step_deg", [-40.0, -12.0, 7.0, 25.0, 90.0])
def test_a_free_turn_is_set_by_a_known_step(step_deg):
    """The camera's y axis points down: a positive step goes counterclockwise seen from above."""
    up, point = np.array([0, -1.0, 0]), np.array([0.01, 0, 0.9])
    right = poses.turn_about(up, point, np.radians(step_deg))
    wrong = poses.turn_about(up, point, np.radians(63.0)) @ right
    for axis in (up, -up):
        assert np.allclose(turn_by_step(wrong, Freedom("turn", axis, point), step_deg), right, atol=1e-3)


def test_a_known_step_of_a_tilted_camera_leaves_what_is_not_free():
    """The camera looks down on a bottle: the axis is tilted, and the pair was found with an error across it."""
    axis, point = np.array([0, -0.9, -np.sqrt(0.19)]), np.array([0.01, 0, 0.9])
    across = poses.turn_about(np.array([1.0, 0, 0]), point, np.radians(0.3))
    right = poses.turn_about(axis, point, np.radians(20))
    wrong = poses.turn_about(axis, point, np.radians(150)) @ across @ right
    found = turn_by_step(wrong, Freedom("turn", axis, point), 20)
    assert degrees(found, right) < 0.5
    assert np.allclose((found @ np.append(point, 1))[:3], (across @ np.append(point, 1))[:3], atol=1e-6)
