"""Composition of pairs (4.17), and what a broken pair means for the views after it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from orbitscan.processing.reconstruction.trajectory import Trajectory, begin_trajectories
from orbitscan.processing.results.estimates import Evidence, PairEstimate
from orbitscan.processing.results.status import Status
from tests.geometry import random_pose


def view(index):
    return SimpleNamespace(surface=SimpleNamespace(view=index))


def pair(source, target, T, status="ok"):
    return PairEstimate(source, target, T, Status(status), 1.0, Evidence())


def test_poses_are_the_product_of_the_pairs():
    rng = np.random.default_rng(0)
    steps = [random_pose(rng) for _ in range(4)]
    trajectory = Trajectory()
    trajectory.start(view(0))
    for i, T in enumerate(steps):
        trajectory.extend(view(i + 1), pair(i + 1, i, T), trajectory.last)
    expected = np.eye(4)
    for estimate, T in zip(trajectory.views, [np.eye(4), *steps], strict=True):
        expected = expected @ T
        assert np.allclose(estimate.T_0_i, expected)
        assert estimate.status == "ok"


def test_views_behind_a_broken_pair_are_placed_but_not_connected():
    trajectory = Trajectory()
    trajectory.start(view(0))
    for i, status in enumerate(["ok", "diverged", "ok", "low_overlap"], start=1):
        trajectory.extend(view(i), pair(i, i - 1, np.eye(4), status), trajectory.last)
    assert [v.status for v in trajectory.views] == ["ok", "ok", "diverged", "not_connected", "low_overlap"]
    assert trajectory.anchor.prepared.surface.view == 1
    trajectory.extend(view(5), pair(5, 1, np.eye(4)), trajectory.anchor)
    assert trajectory.views[-1].status == "ok"


def test_a_view_without_an_estimate_is_skipped_and_breaks_nothing():
    trajectory = Trajectory()
    trajectory.start(view(0))
    trajectory.extend(view(1), pair(1, 0, None, "no_consensus"), trajectory.last)
    assert trajectory.last.prepared.surface.view == 0
    trajectory.extend(view(2), pair(2, 0, np.eye(4)), trajectory.last)
    assert [v.status for v in trajectory.views] == ["ok", "no_consensus", "ok"]
    assert trajectory.result(0).summary["failed_views"] == 1


def test_a_view_is_tried_on_the_last_connected_view_and_then_on_the_last():
    retrying, plain = Trajectory(retries=True), Trajectory()
    assert retrying.targets == plain.targets == []
    for trajectory in (retrying, plain):
        trajectory.start(view(0))
        assert [t.prepared.surface.view for t in trajectory.targets] == [0]
        trajectory.extend(view(1), pair(1, 0, np.eye(4), "diverged"), trajectory.last)
    assert [t.prepared.surface.view for t in retrying.targets] == [0, 1]
    assert [t.prepared.surface.view for t in plain.targets] == [1]


def test_the_step_is_that_of_the_last_pair_if_it_is_right():
    trajectory, T = Trajectory(), random_pose(np.random.default_rng(0))
    trajectory.start(view(0))
    assert trajectory.step is None
    trajectory.extend(view(1), pair(1, 0, T), trajectory.last)
    assert (trajectory.step == T).all()
    trajectory.extend(view(2), pair(2, 1, T, "diverged"), trajectory.last)
    assert trajectory.step is None


def test_a_view_is_attached_to_the_first_target_that_it_fits_else_to_the_likeliest():
    trajectory = Trajectory(retries=True)
    trajectory.start(view(0))
    trajectory.extend(view(1), pair(1, 0, np.eye(4), "diverged"), trajectory.last)
    for statuses, confidences, asked, chosen in (
        (("ok", "ok"), (0.1, 0.9), [0], 0),
        (("diverged", "ok"), (0.9, 0.1), [0, 1], 1),
        (("ambiguous", "diverged"), (0.1, 0.9), [0, 1], 0),
        (("diverged", "diverged"), (0.1, 0.9), [0, 1], 1),
    ):
        tried = []

        def register(target, hints, statuses=statuses, confidences=confidences, tried=tried):
            number = target.surface.view
            tried.append(number)
            return replace(pair(2, number, np.eye(4), statuses[number]), confidence=confidences[number])

        found, target = trajectory.attach(register)
        assert tried == asked
        assert found.target == target.prepared.surface.view == chosen


def test_refined_begins_where_pairwise_ends():
    assert list(begin_trajectories(("refined", "icp"))) == ["icp", "pairwise"]
    assert begin_trajectories(()) == {}


def test_only_views_that_are_ok_are_collected():
    trajectory = Trajectory()
    trajectory.start(view(0))
    trajectory.extend(view(1), pair(1, 0, np.eye(4), "diverged"), trajectory.last)
    trajectory.extend(view(2), pair(2, 1, None, "no_consensus"), trajectory.last)
    assert list(trajectory.result(0).placed) == [0]
