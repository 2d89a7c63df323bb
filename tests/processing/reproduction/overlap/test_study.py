"""The overlap study: pairs keep their truth when a camera is rolled, and success is counted as it is defined."""

from functools import partial

import numpy as np
import pytest

from orbitscan.processing.reproduction.overlap import run
from orbitscan.processing.reproduction.overlap import study as overlap
from orbitscan.processing.reproduction.overlap.run import METHODS, Pairs, measure_overlap, pair_up, register_pairs
from orbitscan.processing.reproduction.overlap.trials import collect, judge
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.recorder import poses
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


def test_trials_tell_the_overlap_and_how_each_method_does(monkeypatch):
    monkeypatch.setattr(run, "simulate", partial(run.simulate, focal=300.0))
    task = Pairs("robot", 20, (0, 90), seed=1)
    trials = collect([register_pairs(task)], [task])
    assert [trial["method"] for trial in trials[: len(METHODS)]] == ["icp", "ransac_icp", "pairwise", METHODS[2]]
    assert len(trials) == 2 * len(METHODS)
    assert 0.7 < trials[0]["overlap"] <= 1
    assert trials[0]["start_error_deg"] == pytest.approx(20, abs=1e-6)
    assert 90 < trials[-1]["start_error_deg"] < 110
    assert all(t["success"] for t in trials if t["method"] == "pairwise")
    assert not any(t["success"] for t in trials if t["method"] == "icp" and t["start_deg"] == 90)


def test_views_from_opposite_sides_overlap_less():
    circle = scan(n_views=8)
    beside, opposite = (measure_overlap(circle, view, diameter=1.0) for view in (1, 4))
    assert measure_overlap(circle, 0, diameter=1.0) == 1
    assert beside > opposite + 0.2


@pytest.mark.parametrize(
    ("error", "observable", "success", "ok_but_wrong"),
    [
        ((4.9, 0.049), (4.9, 0.049), True, False),
        ((5.1, 0.0), (5.1, 0.0), False, True),
        ((0.0, 0.051), (0.0, 0.051), False, True),
        ((90.0, 0.0), (0.1, 0.0), False, False),  # the turn of a shape of revolution, declared free
        ((None, None), (None, None), False, True),
    ],
)
def test_a_pose_is_judged_by_its_error_and_a_claim_by_what_it_claims(error, observable, success, ok_but_wrong):
    trial = dict(zip(("error_deg", "error_m", "observable_deg", "observable_m"), (*error, *observable), strict=True))
    assert judge(trial | {"status": "ok"}, diameter=1.0) == {"success": success, "ok_but_wrong": ok_but_wrong}
    assert not judge(trial | {"status": "diverged"}, diameter=1.0)["ok_but_wrong"]


def test_a_run_depends_on_all_that_makes_its_pair():
    task = Pairs("robot", 20, (0, 90), seed=1)
    others = (Pairs("bin", 20, (0, 90), 1), Pairs("robot", 30, (0, 90), 1), Pairs("robot", 20, (0,), 1))
    assert all(other.key != task.key for other in (*others, Pairs("robot", 20, (0, 90), 2)))


def study(monkeypatch, plan, succeeds):
    """The report of trials that succeed where the function of method, azimuth, start and object says so."""

    def keep(plan, work, tasks, what):
        return [
            {
                "overlap": 1 - task.azimuth_deg / 200,
                "diameter_m": 1.0,
                "trials": [trial(task, method, start) for start in task.starts_deg for method in METHODS],
            }
            for task in tasks
        ]

    def trial(task, method, start):
        error = 0.0 if succeeds(method, task.azimuth_deg, start, task.what) else 90.0
        errors = {"error_deg": error, "error_m": 0.0, "observable_deg": error, "observable_m": 0.0}
        return {"method": method, "start_deg": start, "start_error_deg": start, "status": "ok"} | errors

    monkeypatch.setattr(overlap, "keep", keep)
    return overlap.vary_overlap(plan)


def verdicts(report):
    return {claim.text.split(" succeeds")[0]: claim.verdict for claim in report.claims}


def test_the_verdict_is_whether_a_turned_start_matters(monkeypatch, tmp_path):
    def succeeds(method, azimuth, start, what):
        return {"icp": start == 0, "ransac_icp": what != "bin"}.get(method, False)

    report = study(monkeypatch, Plan(tmp_path, runs=3, fraction=0.1), succeeds)
    found = verdicts(report)
    assert "from a turned start (0 % of the trials) as from an unturned one (100 %)" in report.claims[0].text
    assert found["icp"] == "does not hold"
    assert found["ransac_icp"] == "holds"
    assert found["pairwise"] == "cannot be told"  # what never succeeds is independent of nothing


def test_one_run_gives_no_verdict(monkeypatch, tmp_path):
    report = study(monkeypatch, Plan(tmp_path, runs=1, fraction=0.1), lambda *where: True)
    assert set(verdicts(report).values()) == {"cannot be told"}


def test_the_reach_ends_where_success_does(monkeypatch, tmp_path):
    report = study(
        monkeypatch,
        Plan(tmp_path, runs=1),
        lambda method, azimuth, start, what: azimuth <= 80 and what != "bin" and method != "icp",
    )
    assert "ransac_icp succeeds in 90 % of the trials nowhere, in 50 % down to 60 % overlap." in report.said
    assert "icp succeeds in 90 % of the trials nowhere, in 50 % nowhere." in report.said
    assert "bin nowhere, statue down to 60 % overlap" in report.said[-2]
    assert report.said[-1].startswith("Poses called ok that are wrong: icp 250 of 250, ransac_icp 130 of 250")


def test_every_trial_is_in_a_row_of_each_kind(monkeypatch, tmp_path):
    report = study(monkeypatch, Plan(tmp_path, runs=1), lambda method, azimuth, start, what: azimuth <= 60)
    kinds = [
        [row for row in report.rows if row["overlap_from_to_percent"]],
        [row for row in report.rows if row["azimuth_deg"] and row["object"] == "all"],
        [row for row in report.rows if row["object"] != "all"],
    ]
    trials = len(overlap.OBJECTS) * len(overlap.AZIMUTHS_DEG) * len(overlap.STARTS_DEG) * len(METHODS)
    assert [sum(row["trials"] for row in rows) for rows in kinds] == [trials] * 3
    assert {row["success_percent"] for row in kinds[1] if row["azimuth_deg"] == 80} == {0}
    assert all(0 <= row["low_percent"] <= row["success_percent"] <= row["high_percent"] <= 100 for row in report.rows)


def test_a_small_fraction_is_a_coarser_grid(monkeypatch, tmp_path):
    report = study(monkeypatch, Plan(tmp_path, runs=1, fraction=0.02), lambda *where: True)
    assert {row["azimuth_deg"] for row in report.rows} == {None, 20, 60, 120}
    assert {row["start_deg"] for row in report.rows} == {None, 0, 90}
