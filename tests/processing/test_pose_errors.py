"""The error measures, by their definitions and properties."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orbitscan.processing import pose_errors
from orbitscan.processing.pipeline import process
from orbitscan.processing.results.estimates import Freedom, MethodResult, ViewEstimate
from orbitscan.processing.results.records import Centroid, SessionResult, ViewResult
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses
from tests.geometry import bottle, random_pose, scan, sphere
from tests.processing.scene import Scene, edge


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6))
def test_no_error_against_itself_and_symmetric(seed):
    rng = np.random.default_rng(seed)
    A, B, center = random_pose(rng), random_pose(rng), rng.normal(size=3)
    assert pose_errors.translation_error(A, A) == 0
    assert pose_errors.rotation_error(A, A) < 1e-12
    assert pose_errors.rotation_error(A, B) == pytest.approx(pose_errors.rotation_error(B, A))
    assert 0 <= pose_errors.rotation_error(A, B) <= 2 * np.sqrt(2) + 1e-12
    # Moving both by the same motion changes neither the angle nor where the centre comes to lie.
    M = random_pose(rng)
    assert pose_errors.rotation_error_deg(M @ A, M @ B) == pytest.approx(pose_errors.rotation_error_deg(A, B), abs=1e-6)
    assert pose_errors.center_error(M @ A, M @ B, center) == pytest.approx(pose_errors.center_error(A, B, center))


@pytest.mark.parametrize("degrees", [1e-5, 0.01, 1, 20, 90, 179.9])
def test_chordal_distance_is_its_formula(degrees):
    axis = np.array([1.0, 2, -2]) / 3
    R = poses.make(Rotation.from_rotvec(np.radians(degrees) * axis).as_matrix(), np.zeros(3))
    expected = 2 * np.sqrt(2) * abs(np.sin(np.radians(degrees) / 2))
    assert pose_errors.rotation_error(np.eye(4), R) == pytest.approx(expected, rel=1e-6)
    assert pose_errors.rotation_error_deg(np.eye(4), R) == pytest.approx(degrees, rel=1e-6)


def test_center_error_does_not_grow_with_the_cameras_distance():
    turn = poses.make(Rotation.from_euler("y", 1, degrees=True).as_matrix(), np.zeros(3))
    for distance in (1.0, 100.0):
        center = np.array([0, 0, distance])
        about = poses.make(np.eye(3), center)
        T = about @ turn @ poses.invert(about)
        assert pose_errors.translation_error(np.eye(4), T) > 0.01 * distance
        assert pose_errors.center_error(np.eye(4), T, center) < 1e-12


@pytest.fixture(scope="module")
def stream():
    session = scan(n_views=3, points=14_000)
    return session, list(process(session.views(), session.info))


def test_errors_are_those_of_the_poses(stream):
    session, results = stream
    truth = session.truth()
    *views, last = pose_errors.with_errors(results, truth)
    assert all(isinstance(view, ViewResult) for view in views)
    assert isinstance(last, SessionResult)
    for method, found in last.reconstruction.items():
        for view in found.views:
            T = poses.invert(truth[0]) @ truth[view.view]
            assert view.errors.translation_error_m == pose_errors.translation_error(T, view.T_0_i)
            assert view.errors.rotation_error_chordal == pose_errors.rotation_error(T, view.T_0_i)
            if method != "refined":  # which comes when all views are known
                in_stream = views[view.view].poses[method].errors
                assert in_stream.rotation_error_chordal == view.errors.rotation_error_chordal
        values = [view.errors.center_error_m for view in found.views[1:]]
        assert found.summary["max_center_error_m"] == max(values)
        assert found.summary["median_center_error_m"] == np.median(values)
        if method != "refined":  # whose poses are no chain of pairs
            assert found.pairs[0].errors.center_error_m == pytest.approx(values[0], rel=1e-6)


def test_pairs_are_compared_with_the_true_pair(stream):
    session, results = stream
    truth = session.truth()
    *views, last = pose_errors.with_errors(results, truth)
    for found in last.reconstruction.values():
        for pair in found.pairs:
            T = poses.invert(truth[pair.target]) @ truth[pair.source]
            expected = pose_errors.rotation_error_deg(T, pair.T_target_source)
            assert pair.errors.rotation_error_deg == pytest.approx(expected, abs=1e-6)
            assert pair.errors.rotation_error_deg_observable <= pair.errors.rotation_error_deg + 1e-9
    (in_stream,) = [pair.errors for name, pair in views[1].pairs.items() if name == "pairwise"]
    assert in_stream.rotation_error_deg == last.reconstruction["pairwise"].pairs[0].errors.rotation_error_deg
    assert in_stream.center_error_m is None  # the centre is known only when all views are


def test_the_center_is_the_mean_of_all_points_placed_by_the_truth(stream):
    """A half turn about any axis through it leaves it where it is, and moves all that is not on the axis."""
    session, (*_, last) = stream
    truth = session.truth()
    placed = [poses.transform(poses.invert(truth[0]) @ truth[v.index], v.points) for v in session.views()]
    center = np.concatenate(placed).mean(axis=0)
    T_0_1 = poses.invert(truth[0]) @ truth[1]
    for axis in np.eye(3):
        views = (
            ViewEstimate(0, Status.OK, np.eye(4)),
            ViewEstimate(1, Status.OK, poses.turn_about(axis, center, np.pi) @ T_0_1),
        )
        (found,) = pose_errors.with_errors([replace(last, reconstruction={"icp": MethodResult(views, ())})], truth)
        turned = found.reconstruction["icp"].views[1].errors
        assert turned.rotation_error_deg == pytest.approx(180)
        assert turned.center_error_m < 2e-6


def test_without_truth_errors_are_null_and_nothing_else_changes(stream):
    _, results = stream
    *_, last = pose_errors.with_errors(results, {})
    for found in last.reconstruction.values():
        assert all(view.errors.translation_error_m is None for view in found.views)
        assert found.summary["max_rotation_error_chordal"] is None
        assert all(pair.errors.rotation_error_deg is None for pair in found.pairs)
    assert last.reconstruction["pairwise"].summary["failed_views"] == 0


def test_truth_of_some_views_gives_errors_of_those(stream):
    session, results = stream
    truth = {0: session.truth()[0], 2: session.truth()[2]}
    *_, last = pose_errors.with_errors(results, truth)
    known = [view.errors.rotation_error_deg is not None for view in last.reconstruction["pairwise"].views]
    assert known == [True, False, True]


CENTER = np.array([0.0, 0.02, 1.0])  # of the object, in the first view
TRUTH = {0: np.eye(4), 1: random_pose(np.random.default_rng(8))}


@pytest.fixture(scope="module")
def judge(stream):
    """A function that tells the errors of a pair against a truth, the object's centre in frame {0} given."""

    def errors_of(pair, truth, center):
        found = {"pairwise": MethodResult((ViewEstimate(0, Status.OK, np.eye(4)),), (pair,))}
        session = replace(stream[1][-1], origin=0, centroids={0: Centroid(1, center)}, reconstruction=found)
        (judged,) = pose_errors.with_errors([session], truth)
        return judged.reconstruction["pairwise"].pairs[0].errors

    return errors_of


@pytest.fixture(scope="module")
def of_pair(judge):
    """A function that tells the errors of an estimate T_0_1 against the truth, with what it declares free."""
    return lambda T, **declared: judge(edge(1, 0, T, CENTER, **declared), TRUTH, CENTER)


def test_a_declared_turn_is_no_observable_error(of_pair):
    axis, point = np.array([0.6, 0.8, 0]), np.array([0.01, 0.02, 0.98])
    off = poses.turn_about(axis, point, 2.0) @ TRUTH[1]
    found = of_pair(off, freedoms=(Freedom("turn", axis, point),))
    assert found.rotation_error_deg == pytest.approx(np.degrees(2.0))
    assert found.center_error_m > 0.01
    assert found.rotation_error_deg_observable < 1e-5
    assert found.center_error_m_observable < 1e-9
    undeclared = of_pair(off)
    assert undeclared.rotation_error_deg_observable == undeclared.rotation_error_deg
    assert undeclared.center_error_m_observable == undeclared.center_error_m


def test_only_what_is_declared_is_granted(of_pair):
    axis, across, point = np.array([0, 1.0, 0]), np.array([1.0, 0, 0]), CENTER
    freedom = (Freedom("turn", axis, point),)
    off = poses.turn_about(axis, point, 1.0) @ poses.turn_about(across, point, np.radians(3)) @ TRUTH[1]
    assert of_pair(off, freedoms=freedom).rotation_error_deg_observable == pytest.approx(3)
    aside = poses.make(np.eye(3), [0, 0.03, 0]) @ poses.turn_about(axis, point, 1.0) @ TRUTH[1]
    assert of_pair(aside, freedoms=freedom).center_error_m_observable == pytest.approx(0.03)
    wrong_axis = (Freedom("turn", across, point),)
    off = poses.turn_about(axis, point, 1.0) @ TRUTH[1]
    assert of_pair(off, freedoms=wrong_axis).rotation_error_deg_observable > 50


def test_a_declared_shift_is_no_observable_error(of_pair):
    axis = np.array([0, 0.6, 0.8])
    off = poses.make(np.eye(3), 0.05 * axis) @ TRUTH[1]
    found = of_pair(off, freedoms=(Freedom("shift", axis, CENTER),))
    assert found.center_error_m == pytest.approx(0.05)
    assert found.center_error_m_observable < 1e-9


def test_the_nearest_alternative_counts(of_pair):
    half = poses.turn_about(np.array([0, 1.0, 0]), CENTER, np.pi) @ TRUTH[1]
    other = poses.turn_about(np.array([0, 1.0, 0]), CENTER, 1.0) @ TRUTH[1]
    found = of_pair(half, alternatives=(other, TRUTH[1]))
    assert found.rotation_error_deg == pytest.approx(180)
    assert found.rotation_error_deg_observable < 1e-5
    assert found.center_error_m_observable < 1e-9
    assert of_pair(half, alternatives=(other,)).rotation_error_deg_observable == pytest.approx(np.degrees(1.0))


@pytest.mark.parametrize(("surface", "raw_deg"), [(bottle, 5), (sphere, 5)])
def test_what_a_scan_leaves_open_is_all_that_is_wrong_with_a_pair(surface, raw_deg, judge):
    scene = Scene(scan(n_views=2, surface=surface, points=10_000))
    pair = scene.register(scene.views[1], scene.views[0])
    center = poses.invert(scene.truth[0])[:3, 3]
    found = judge(pair, scene.truth, center)
    assert found.rotation_error_deg > raw_deg
    assert found.rotation_error_deg_observable < 0.5
    assert found.center_error_m_observable < 0.001
