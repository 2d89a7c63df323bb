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
    assert trajectory.result().summary["failed_views"] == 1


def test_a_view_is_tried_on_the_last_connected_view_and_then_on_the_last():
    doubting, plain = Trajectory(doubts=True), Trajectory()
    assert doubting.targets == plain.targets == []
    for trajectory in (doubting, plain):
        trajectory.start(view(0))
        assert [t.prepared.surface.view for t in trajectory.targets] == [0]
        trajectory.extend(view(1), pair(1, 0, np.eye(4), "diverged"), trajectory.last)
    assert [t.prepared.surface.view for t in doubting.targets] == [0, 1]
    assert [t.prepared.surface.view for t in plain.targets] == [1]


def test_a_view_that_fits_neither_is_tried_on_two_earlier_ones():
    trajectory = Trajectory(doubts=True)
    trajectory.start(view(0))
    for i in range(1, 5):
        trajectory.extend(view(i), pair(i, i - 1, np.eye(4)), trajectory.last)
    asked = []

    def register(target, hints):
        asked.append(target.surface.view)
        return pair(5, target.surface.view, np.eye(4), "ok" if target.surface.view == 2 else "diverged")

    found, target = trajectory.attach(register)
    assert asked == [4, 3, 2]
    assert found.target == target.prepared.surface.view == 2
    assert Trajectory().earlier == []


def chained(statuses, **options):
    """A trajectory of views that each stand a metre from the one before, by pairs of such statuses."""
    trajectory, step = Trajectory(**options), np.eye(4)
    step[0, 3] = 1
    trajectory.start(view(0))
    for i, status in enumerate(statuses, start=1):
        trajectory.extend(view(i), pair(i, i - 1, step, status), trajectory.last)
    return trajectory


def places(views):
    """Where views stand, in frame {0} or that of their component."""
    poses = [v.T_0_i if v.T_component_i is None else v.T_component_i for v in views]
    return [None if T is None else T[0, 3] for T in poses]


def test_views_behind_a_pair_in_doubt_hold_together_apart():
    trajectory = chained(["ok", "diverged", "ok", "ambiguous"], doubts=True)
    assert [v.status for v in trajectory.views] == ["ok", "ok", "diverged", "not_connected", "ambiguous"]
    assert [v.component for v in trajectory.views] == [0, 0, None, 1, 1]
    assert places(trajectory.views) == [0, 1, 0, 1, 2]


def test_in_the_end_the_most_that_hold_together_are_in_frame_0():
    found = chained(["diverged", "ok", "ok", "low_overlap", "ok"], doubts=True).result()
    assert [v.status for v in found.views] == ["not_connected", "ok", "ok", "ok", "not_connected", "not_connected"]
    assert [v.component for v in found.views] == [None, 0, 0, 0, 1, 1]
    assert places(found.views) == [None, 0, 1, 2, 0, 1]
    assert found.origin == 1
    assert list(found.placed) == [1, 2, 3]
    assert {k: list(views) for k, views in found.components.items()} == {1: [4, 5]}
    assert found.views[4].note == "one of 2 views that hold together, but nothing holds them to the others"


def test_the_frame_is_that_of_an_origin_where_one_is_given():
    found = chained(["diverged", "ok", "ok", "low_overlap", "ok"], doubts=True).result(5)
    assert [v.component for v in found.views] == [None, 1, 1, 1, 0, 0]
    assert places(found.views) == [None, 0, 1, 2, -1, 0]
    assert [v.status for v in found.views[4:]] == ["ok", "ok"]


def test_the_thesis_methods_go_through_any_pair():
    trajectory = chained(["diverged", "ok", "ok"])
    assert [v.status for v in trajectory.result().views] == ["ok", "diverged", "not_connected", "not_connected"]
    found = trajectory.result(1)
    assert places(found.views) == [-1, 0, 1, 2]
    assert [v.status for v in found.views] == ["not_connected", "ok", "ok", "ok"]


def test_views_without_points_stay_what_they_are():
    trajectory = chained(["ok"], doubts=True)
    trajectory.skip(2, Status.TOO_FEW_POINTS)
    assert [v.status for v in trajectory.result(1).views] == ["ok", "ok", "too_few_points"]
    empty = Trajectory()
    empty.skip(0, Status.UNREADABLE)
    assert empty.result().origin is None


def test_the_step_is_that_of_the_last_pair_if_it_is_right():
    trajectory, T = Trajectory(), random_pose(np.random.default_rng(0))
    trajectory.start(view(0))
    assert trajectory.step is None
    trajectory.extend(view(1), pair(1, 0, T), trajectory.last)
    assert (trajectory.step == T).all()
    trajectory.extend(view(2), pair(2, 1, T, "diverged"), trajectory.last)
    assert trajectory.step is None


def test_a_view_is_attached_to_the_first_target_that_it_fits_else_to_the_likeliest():
    trajectory = Trajectory(doubts=True)
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
    assert list(trajectory.result().placed) == [0]
