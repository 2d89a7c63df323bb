"""Geometry as properties of random motions."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose
from tests.geometry import random_pose

seeds = st.integers(0, 2**32 - 1)
stamps = st.integers(0, 2**63 - 1)


@given(seeds)
def test_the_inverse_undoes_a_motion(seed):
    T = random_pose(np.random.default_rng(seed))
    np.testing.assert_allclose(poses.invert(T) @ T, np.eye(4), atol=1e-12)
    np.testing.assert_allclose(poses.invert(T), np.linalg.inv(T), atol=1e-12)


@given(seeds)
def test_transforming_twice_is_transforming_by_the_product(seed):
    rng = np.random.default_rng(seed)
    T_a_b, T_b_c, points = random_pose(rng), random_pose(rng), rng.normal(size=(5, 3))
    twice = poses.transform(T_a_b, poses.transform(T_b_c, points))
    np.testing.assert_allclose(twice, poses.transform(T_a_b @ T_b_c, points), atol=1e-12)


@given(seeds, st.floats(0, np.pi))
def test_the_angle_of_a_rotation_and_its_chordal_distance(seed, angle):
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    R_a = Rotation.random(rng=rng).as_matrix()
    R_b = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix() @ R_a
    assert poses.rotation_angle(R_b @ R_a.T) == pytest.approx(angle, abs=1e-7)
    assert poses.chordal_distance(R_a, R_b) == pytest.approx(2 * np.sqrt(2) * np.sin(angle / 2), abs=1e-9)


def test_a_tiny_angle_is_not_lost():
    R = Rotation.from_rotvec([0, 0, 1e-9]).as_matrix()
    assert poses.rotation_angle(R) == pytest.approx(1e-9, rel=1e-3)


@given(seeds)
def test_the_projection_is_the_nearest_rotation(seed):
    rng = np.random.default_rng(seed)
    M = rng.normal(size=(3, 3))
    R = poses.project_rotation(M)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1)
    others = [Rotation.random(rng=rng).as_matrix() for _ in range(20)]
    assert np.linalg.norm(M - R) <= min(np.linalg.norm(M - other) for other in others)


@given(seeds)
def test_quaternions_there_and_back(seed):
    T = random_pose(np.random.default_rng(seed))
    quaternion = poses.to_quaternion(T)
    assert quaternion[3] >= 0
    np.testing.assert_allclose(poses.from_quaternion(T[:3, 3], quaternion, "q"), T, atol=1e-12)
    np.testing.assert_allclose(poses.from_quaternion(T[:3, 3], -quaternion, "q"), T, atol=1e-12)


def test_a_quaternion_is_hamilton_with_w_last():
    half = np.sqrt(0.5)
    T = poses.from_quaternion(np.array([1, 2, 3]), np.array([0, 0, half, half]), "q")  # a quarter turn about z
    np.testing.assert_allclose(poses.transform(T, [[1, 0, 0]]), [[1, 3, 3]], atol=1e-12)


@pytest.mark.parametrize("quaternion", [(0, 0, 0, 0), (0, 0, 0, 2), (np.nan, 0, 0, 1), (np.inf, 0, 0, 1)])
def test_a_quaternion_of_another_length_is_refused(quaternion):
    with pytest.raises(InvalidPose, match=r"pose 7: a quaternion has the length"):
        poses.from_quaternion(np.zeros(3), np.array(quaternion), "pose 7")


@given(seeds, stamps)
def test_tum_lines_there_and_back(seed, stamp_ns):
    T = random_pose(np.random.default_rng(seed))
    found_ns, found = poses.from_tum_line(poses.to_tum_line(stamp_ns, T), "line")
    assert found_ns == stamp_ns
    np.testing.assert_allclose(found, T, atol=1e-10)


@pytest.mark.parametrize(
    ("words", "stamp_ns"),
    [
        ("0", 0),
        ("12.5", 12_500_000_000),
        ("1305031102.175304", 1_305_031_102_175_304_000),
        ("1700000000.123456789", 1_700_000_000_123_456_789),
        ("1.5e3", 1_500_000_000_000),
    ],
)
def test_stamps_keep_their_nanoseconds(words, stamp_ns):
    assert poses.from_tum_line(f"{words} 0 0 0 0 0 0 1", "line")[0] == stamp_ns


@pytest.mark.parametrize("line", ["", "1 2 3", "1 2 3 4 5 6 7 8 9", "a 0 0 0 0 0 0 1", "1 0 0 0 0 0 zero 1"])
def test_a_line_that_is_not_tum_is_refused(line):
    with pytest.raises(InvalidPose, match=r"poses\.tum, line 3: a TUM line"):
        poses.from_tum_line(line, "poses.tum, line 3")


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda T: T[:3], "shape"),
        (lambda T: T * np.nan, "not finite"),
        (lambda T: T + 0.1 * np.eye(4)[3:].T, "last row"),
        (lambda T: T @ np.diag([1.01, 1, 1, 1]), "not a rotation"),
        (lambda T: T @ np.diag([1, 1, -1, 1]), "mirrors"),
        (lambda T: T @ np.diag([0, 0, 0, 1]), "not a rotation"),
    ],
)
def test_what_is_no_rigid_motion_is_refused(change, what):
    with pytest.raises(InvalidPose, match=what):
        poses.check(change(random_pose(np.random.default_rng(1))), "pose 3")


def test_a_rotation_written_with_four_digits_is_made_whole():
    T = random_pose(np.random.default_rng(2))
    checked = poses.check(np.round(T, 4), "pose")
    np.testing.assert_allclose(checked[:3, :3] @ checked[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(checked, T, atol=2e-4)


@pytest.mark.parametrize(
    ("axes", "forward", "up"),  # in the named frame
    [
        ("RDF", (0, 0, 1), (0, -1, 0)),
        ("RUB", (0, 0, -1), (0, 1, 0)),
        ("RFU", (0, 1, 0), (0, 0, 1)),
        ("FLU", (1, 0, 0), (0, 0, 1)),
    ],
)
def test_axes_lead_to_right_down_forward(axes, forward, up):
    A = poses.axes_to_rdf(axes)
    np.testing.assert_array_equal(A @ forward, (0, 0, 1))
    np.testing.assert_array_equal(A @ up, (0, -1, 0))
    np.testing.assert_array_equal(A, poses.axes_to_rdf(axes.lower()))


def test_of_all_names_24_are_frames_and_all_are_rotations():
    found = []
    for letters in product("RLDUFB", repeat=3):
        try:
            found.append(poses.axes_to_rdf("".join(letters)))
        except InvalidOption:
            continue
    assert len(found) == 24
    assert len({A.tobytes() for A in found}) == 24
    assert all(np.linalg.det(A) == pytest.approx(1) and np.array_equal(A @ A.T, np.eye(3)) for A in found)


@pytest.mark.parametrize(
    ("axes", "what"), [("XYZ", "not three of"), ("RD", "not three of"), ("RLF", "one line"), ("RUF", "left-handed")]
)
def test_names_that_are_no_frame_are_refused(axes, what):
    with pytest.raises(InvalidOption, match=what):
        poses.axes_to_rdf(axes)


@given(seeds, st.floats(-3.1, 3.1), st.floats(-3.1, 3.1))
def test_a_turn_about_a_line_leaves_the_line_where_it_is_and_turns_add_up(seed, angle, more):
    rng = np.random.default_rng(seed)
    axis, point = rng.normal(size=(2, 3))
    axis /= np.linalg.norm(axis)
    T = poses.turn_about(axis, point, angle)
    line = point + rng.normal(size=(5, 1)) * axis
    np.testing.assert_allclose(poses.transform(T, line), line, atol=1e-12)
    assert poses.twist(T[:3, :3], axis) == pytest.approx(angle, abs=1e-9)
    np.testing.assert_allclose(poses.invert(T), poses.turn_about(axis, point, -angle), atol=1e-12)
    both = poses.turn_about(axis, point, more) @ T
    np.testing.assert_allclose(both, poses.turn_about(axis, point, angle + more), atol=1e-12)


@given(seeds)
def test_a_twist_is_the_turn_about_an_axis_that_a_rotation_begins_with(seed):
    rng = np.random.default_rng(seed)
    axis, across, angle = *rng.normal(size=(2, 3)), rng.uniform(-3.1, 3.1)
    axis /= np.linalg.norm(axis)
    across -= across @ axis * axis
    swing = Rotation.from_rotvec(across / np.linalg.norm(across) * rng.uniform(-3, 3)).as_matrix()
    turn = Rotation.from_rotvec(angle * axis).as_matrix()
    assert abs(poses.twist(swing, axis)) < 1e-9
    assert poses.twist(turn, axis) == pytest.approx(angle)
    assert poses.twist(turn @ swing, axis) == pytest.approx(angle)
    assert poses.twist(turn, -axis) == pytest.approx(-angle)
