"""Composition of pairs (4.17), and what a broken pair means for the views after it."""

from types import SimpleNamespace

import numpy as np

from processing.reconstruction.trajectory import Trajectory
from processing.results.records import Evidence, PairEstimate
from tests.geometry import random_pose


def view(index):
    return SimpleNamespace(surface=SimpleNamespace(view=index))


def pair(source, target, T, status="ok"):
    return PairEstimate(source, target, T, status, 1.0, Evidence())


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
    assert set(trajectory.poses()) == {0, 1}
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
