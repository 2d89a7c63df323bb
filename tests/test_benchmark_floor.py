"""The benchmark's floor: the covariance that it predicts is the one that noise makes; free motions are left out."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.processing.pose_errors import center_error, rotation_error_deg
from orbitscan.recorder import poses
from tests.benchmarks import floor
from tests.benchmarks.scores import score_pair, score_session
from tests.benchmarks.sessions import Case, build


def patches(rng, n=60):
    """Points and unit normals of a saddle that bends more to one side, so that it determines all six motions."""
    x, y = rng.uniform(-0.1, 0.1, (2, n))
    slope = np.column_stack([12 * x - 5 * y + 120 * x**2, -5 * x - 8 * y, -np.ones(n)])
    points = np.column_stack([x, y, 6 * x**2 - 5 * x * y - 4 * y**2 + 40 * x**3 + 0.7])
    return points, slope / np.linalg.norm(slope, axis=1, keepdims=True)


def cylinder(rng, n=400, radius=0.05):
    """Points and normals of a can with its lid, axis z."""
    angle = rng.uniform(0, 2 * np.pi, n)
    out = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])
    wall = radius * out + np.outer(rng.uniform(0, 0.2, n), (0, 0, 1))
    lid = rng.uniform(0, radius, (n, 1)) * out + (0, 0, 0.2)
    return np.concatenate([wall, lid]), np.concatenate([out, np.broadcast_to((0.0, 0, 1), (n, 3))])


def test_the_floor_is_the_scatter_of_least_squares():
    rng = np.random.default_rng(0)
    points, normals = patches(rng)
    source_count, target_count = rng.integers(1, 9, (2, len(points)))  # points of each view on a patch
    s, t = 1e-3 * rng.uniform(0.5, 2, (2, len(points)))  # their noise along the normal
    variance = floor.pair_variance(s**2, t**2, source_count, target_count)
    each = np.repeat(np.arange(len(points)), source_count)  # a row for every source point
    information = floor.inform(points[each], normals[each], variance[each])
    assert information.free().shape == (6, 0)
    predicted = information.covariance(information.free())

    # Draw the views, fit the motion between the patches' means by weighted least squares, over and over.
    draws = 4000
    here = rng.standard_normal((draws, len(points))) * s / np.sqrt(source_count)
    there = rng.standard_normal((draws, len(points))) * t / np.sqrt(target_count)
    J = np.hstack([np.cross(points - information.center, normals), normals])
    weight = 1 / np.sqrt(s**2 / source_count + t**2 / target_count)
    found = np.linalg.lstsq(J * weight[:, None], (weight * (here - there)).T, rcond=None)[0]
    scatter = np.cov(found)
    spread = np.sqrt(np.outer(np.diag(predicted), np.diag(predicted)))
    assert np.abs((scatter - predicted) / spread).max() < 0.1
    assert floor.rotation_floor_deg(predicted) == pytest.approx(
        np.degrees(np.sqrt((found[:3] ** 2).sum(0).mean())), rel=0.05
    )
    where = np.array([0.3, -0.2, 0.5])
    moved = found[3:].T + np.cross(found[:3].T, where - information.center)
    assert floor.center_floor(predicted, information.center, where) == pytest.approx(
        np.sqrt((moved**2).sum(axis=1).mean()), rel=0.05
    )


def test_a_turn_that_nothing_shows_is_left_out_of_floor_and_error():
    points, normals = cylinder(np.random.default_rng(1))
    tilt = poses.make(Rotation.from_rotvec([0.3, 0.2, 0.1]).as_matrix(), np.array([0.1, 0.2, 1.0]))
    points, normals = poses.transform(tilt, points), normals @ tilt[:3, :3].T
    information = floor.inform(points, normals, np.full(len(points), 1e-6))
    free = information.free()
    assert free.shape == (6, 1)
    declared = information.twist(tilt[:3, 2], tilt[:3, 3] + 0.3 * tilt[:3, 2], "turn")
    assert abs(declared @ free[:, 0]) > 0.999
    assert 0 < floor.rotation_floor_deg(information.covariance(free)) < 0.1

    def turned(degrees):
        about = Rotation.from_rotvec(np.radians(degrees) * np.array([0, 0, 1.0])).as_matrix()
        return tilt @ poses.make(about, np.zeros(3)) @ poses.invert(tilt)

    exact = declared[:, None]
    for degrees in (1, 20, 170):
        left = floor.take_out(turned(degrees), exact, information.center, information.lever)
        assert rotation_error_deg(np.eye(4), left) < 1e-6
        assert center_error(np.eye(4), left, information.center) < 1e-9
    # What the can does show stays: a tilt of one degree after a turn of twenty.
    leaning = poses.make(Rotation.from_rotvec(np.radians(1) * tilt[:3, 0]).as_matrix(), np.zeros(3))
    left = floor.take_out(leaning @ turned(20), exact, information.center, information.lever)
    assert rotation_error_deg(np.eye(4), left) == pytest.approx(1, rel=0.02)


def test_a_declared_shift_is_taken_out():
    points, normals = cylinder(np.random.default_rng(2))
    information = floor.inform(points, normals, np.full(len(points), 1e-6))
    shift = information.twist(np.array([0, 0, 2.0]), np.zeros(3), "shift")
    error = poses.make(np.eye(3), np.array([0.001, 0, 0.5]))
    left = floor.take_out(error, shift[:, None], information.center, information.lever)
    np.testing.assert_allclose(left[:3, 3], [0.001, 0, 0], atol=1e-9)


def test_a_chain_adds_the_covariances_of_its_ends():
    points, normals = patches(np.random.default_rng(3))
    center, lever = points.mean(axis=0), 0.1
    good = floor.inform(points, normals, np.full(len(points), 1e-6), center, lever)
    bad = floor.inform(points, normals, np.full(len(points), 3e-6), center, lever)
    chain = floor.chain_covariance(good, bad, good.free())
    assert floor.rotation_floor_deg(chain) == pytest.approx(2 * floor.rotation_floor_deg(good.covariance(good.free())))


def relative(scan, source, target):
    truth = scan.session.truth()
    return poses.invert(truth[target]) @ truth[source]


def test_densities_foretell_how_many_points_of_the_other_view_are_in_the_overlap(open3d):
    scan = build(Case("robot", 40, views=2, outliers=0))
    seen, T = scan.seen, scan.T_object_camera
    here, there = (scan.density(seen[1], view) for view in (1, 0))
    common = scan.scene.visible(T[0][:3, 3], seen[1].points) & (here > 0) & (there > 0)
    back = scan.scene.visible(T[1][:3, 3], seen[0].points) & (scan.density(seen[0], 1) > 0)
    assert (there[common] / here[common]).sum() == pytest.approx(back.sum(), rel=0.03)


@pytest.mark.parametrize("name", ["bowl", "water_bottle", "robot"])
def test_what_turns_unseen_is_found_and_granted_where_it_is_declared(open3d, name):
    scan = build(Case(name, 40, views=2, random_frames=True, size=2.0))
    true = relative(scan, 1, 0)
    exact = score_pair(scan, "pairwise", 1, 0, true)
    assert exact.right
    assert exact.observable_deg < 1e-5
    assert exact.free_motions == (name != "robot")

    T_object_target = scan.session.truth()[0]
    turn = poses.make(Rotation.from_euler("z", 30, degrees=True).as_matrix(), np.zeros(3))
    turned = poses.invert(T_object_target) @ turn @ T_object_target @ true
    axis, point = poses.invert(T_object_target)[:3, 2], poses.invert(T_object_target)[:3, 3]
    freedom = SimpleNamespace(axis=axis, point=point, kind="turn")
    assert not score_pair(scan, "pairwise", 1, 0, turned).right
    declared = score_pair(scan, "pairwise", 1, 0, turned, freedoms=[freedom])
    assert declared.observable_deg < 1e-5
    assert declared.right == (name != "robot")
    assert declared.false_freedom == (name == "robot")
    assert score_pair(scan, "a peer", 1, 0, turned, freedoms=None).right == (name != "robot")


def test_size_and_frames_change_no_floor_in_degrees(open3d):
    plain, changed = (build(Case("robot", 40, views=2, **how)) for how in ({}, {"size": 0.05, "random_frames": True}))
    a, b = (score_pair(scan, "pairwise", 1, 0, relative(scan, 1, 0)) for scan in (plain, changed))
    assert b.floor_deg == pytest.approx(a.floor_deg, rel=1e-6)
    assert b.floor_mm == pytest.approx(a.floor_mm * changed.diameter / plain.diameter, rel=1e-6)


def test_a_chain_a_floor_long_has_the_ratio_one(open3d):
    scan = build(Case("robot", 40, views=2))
    truth = scan.session.truth()
    first, other = (scan.localized(view, scan.diameter / 4) for view in (0, 1))
    degrees = floor.rotation_floor_deg(floor.chain_covariance(first, other, first.free()))
    off = poses.make(Rotation.from_rotvec([0, np.radians(degrees), 0]).as_matrix(), np.zeros(3))
    estimates = {0: np.eye(4), 1: off @ poses.invert(truth[0]) @ truth[1]}
    assert score_session(scan, "refined", estimates, 0, {}).chain_ratio == pytest.approx(1, rel=1e-6)
