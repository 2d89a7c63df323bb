"""The overlap study: pairs keep their truth when a camera is rolled, and success is counted as it is defined."""

import numpy as np
import pytest

from processing.reproduction import overlap, overlap_runs
from processing.reproduction.overlap_runs import METHODS, Pairs, pair_up, register_pairs
from processing.reproduction.plan import Plan
from recorder import poses
from tests.geometry import scan


@pytest.mark.parametrize("turn", [0, 90, 180])
def test_a_rolled_view_keeps_its_middle_its_sensor_and_its_truth(turn):
    circle = scan(n_views=3)
    pair = pair_up(circle, 2, turn)
    plain, rolled = circle.load(2).points, pair.load(1).points
    truth, pair_truth = circle.truth(), pair.truth()
    assert rolled.mean(axis=0) == pytest.approx(plain.mean(axis=0), abs=1e-4)
    assert np.linalg.norm(rolled, axis=1) == pytest.approx(np.linalg.norm(plain, axis=1), rel=1e-5)
    assert poses.transform(pair_truth[1], rolled) == pytest.approx(poses.transform(truth[2], plain), abs=1e-5)
    turned = pair_truth[1][:3, :3].T @ truth[2][:3, :3]
    assert np.degrees(poses.rotation_angle(turned)) == pytest.approx(turn, abs=1e-4)


@pytest.mark.usefixtures("open3d")
def test_trials_tell_the_overlap_and_how_each_method_does():
    trials = register_pairs(Pairs("robot", (20,), (0, 90), seed=1))["trials"]
    assert [trial["method"] for trial in trials[: len(METHODS)]] == ["icp", "ransac_icp", "pairwise", METHODS[2]]
    assert len(trials) == 2 * len(METHODS)
    assert 0.7 < trials[0]["overlap"] <= 1
    assert all(t["success"] for t in trials if t["method"] == "pairwise")
    assert not any(t["success"] for t in trials if t["method"] == "icp" and t["start_deg"] == 90)
    assert all(t["success"] == (t["rotation_error_deg"] <= 5) for t in trials if t["method"] == "pairwise")


def test_views_from_opposite_sides_overlap_less():
    circle = scan(n_views=8)
    beside, opposite = (overlap_runs._overlap(circle, view, gate=0.01) for view in (1, 4))
    assert overlap_runs._overlap(circle, 0, gate=0.01) == 1
    assert beside > opposite + 0.2


def trial(method, azimuth, start, success, **more):
    return {
        "method": method,
        "azimuth_deg": azimuth,
        "start_deg": start,
        "overlap": 1 - azimuth / 200,
        "status": "ok" if success else "diverged",
        "success": success,
        "ok_but_wrong": False,
    } | more


def study(monkeypatch, plan, succeeds):
    """The report of trials that succeed where the function says so."""

    def keep(plan, work, tasks, what):
        return [
            {
                "trials": [
                    trial(method, azimuth, start, succeeds(method, azimuth, start))
                    for azimuth in task.azimuths_deg
                    for start in task.starts_deg
                    for method in METHODS
                ]
            }
            for task in tasks
        ]

    monkeypatch.setattr(overlap, "keep", keep)
    return overlap.vary_overlap(plan)


def test_the_verdict_is_whether_a_turned_start_matters(monkeypatch, tmp_path):
    report = study(monkeypatch, Plan(tmp_path, runs=2), lambda method, azimuth, start: method != "icp" or start == 0)
    verdicts = {
        line.split(" ")[0]: line.split(": ")[1].split(" (")[0] for line in report.said if "turned start" in line
    }
    assert verdicts["icp"] == "does not hold"
    assert verdicts["ransac_icp"] == "holds"
    assert len(report.rows) == len(METHODS) * len(overlap.AZIMUTHS_DEG) * len(overlap.STARTS_DEG)


def test_the_reach_ends_where_success_does(monkeypatch, tmp_path):
    report = study(monkeypatch, Plan(tmp_path, runs=1), lambda method, azimuth, start: azimuth <= 60)
    assert "ransac_icp succeeds in 90 % of the trials up to 60 degrees apart (70 % overlap)" in report.said[-2]
    far = [row for row in report.rows if row["azimuth_deg"] == 80]
    assert {row["success_percent"] for row in far} == {0}
    assert all(0 <= row["low_percent"] <= row["success_percent"] <= row["high_percent"] <= 100 for row in report.rows)


def test_a_small_fraction_is_a_coarser_grid(monkeypatch, tmp_path):
    report = study(monkeypatch, Plan(tmp_path, runs=1, fraction=0.02), lambda *where: True)
    assert {row["azimuth_deg"] for row in report.rows} == {20, 60, 120}
    assert {row["start_deg"] for row in report.rows} == {0, 90}
