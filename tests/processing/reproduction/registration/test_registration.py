"""The registration studies: circles recorded once, each method on its own, errors and models as they are."""

import numpy as np
import pytest

from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration import errors, models, run, seconds
from orbitscan.processing.reproduction.registration.run import FEW, METHODS, OBJECTS, Circle, Run, list_circles, run_all
from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import ScanError
from orbitscan.recorder.simulation.camera import simulate


@pytest.fixture
def robot(monkeypatch):
    """Five views of one small object instead of all."""
    for module in (run, seconds, errors, models):
        monkeypatch.setattr(module, "OBJECTS", {"robot": 120.0})
    monkeypatch.setattr(run, "FEW", 5)
    monkeypatch.setattr(run, "CIRCLE", 60)


def test_the_few_views_stay_and_the_circle_is_cut(tmp_path):
    circles = list_circles(Plan(tmp_path, runs=2, fraction=0.1))
    assert len(circles) == 2 * 5 + 5
    assert {circle.views for circle in circles if not circle.dense} == {FEW}
    assert {circle.views for circle in circles if circle.dense} == {25}
    assert len({circle.name for circle in circles}) == len(circles)


def test_a_view_has_about_the_thesis_s_points():
    points = {
        what: np.mean([len(view.points) for view in simulate(what, views=6, focal=focal).views()])
        for what, focal in OBJECTS.items()
        if what != "helicopter"  # slow
    }
    assert points == pytest.approx(dict.fromkeys(points, 30_000), rel=0.12)


@pytest.mark.usefixtures("robot")
def test_a_circle_is_recorded_again_where_its_making_changed(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "FEW", 2)
    monkeypatch.setattr(run, "WAYS", ())
    monkeypatch.setattr(run, "METHODS", {})
    plan, path = Plan(tmp_path, runs=1, fraction=0.01), tmp_path / "circles" / "robot-sparse-2-seed-0.mcap"

    def record():
        assert run_all(plan) == []
        return path.read_bytes(), path.stat().st_mtime_ns

    first, stamp = record()
    assert record() == (first, stamp)
    path.with_suffix(".json").unlink()
    again, later = record()
    assert again == first
    assert later > stamp
    monkeypatch.setattr(run, "OBJECTS", {"robot": 60.0})
    assert len(record()[0]) < len(first)


@pytest.mark.usefixtures("robot", "open3d")
def test_all_methods_are_run_once_and_read_back(tmp_path):
    plan = Plan(tmp_path, runs=1, fraction=0.05)
    runs = run_all(plan)
    assert [run.method for run in runs] == [*METHODS, *METHODS]
    sparse = {run.method: run for run in runs if not run.circle.dense}
    assert max(sparse["refined"].errors("rotation_error_chordal")) < 0.05
    assert sparse["icp"].seconds["registration"] > 0
    recorded = mcap_file.read(tmp_path / "circles" / "robot-dense-5-seed-0.mcap")
    assert (recorded.info.views, recorded.info.views_per_turn, len(recorded.truth())) == (5, 60, 5)
    written = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*") if path.is_file()}
    again = run_all(plan)
    assert [run.seconds for run in again] == [run.seconds for run in runs]
    assert {path: path.stat().st_mtime_ns for path in written} == written

    report = models.show_models(plan)
    assert list(report.figures) == ["figure-5.9-robot"]
    off = {row["method"]: row["median_off_mm"] for row in report.rows}
    assert off["refined"] < 2
    assert [row["views"] for row in report.rows if row["method"] == "refined"] == [5]
    for name, study in (("figure-5.8", errors.compare_errors), ("figure-5.10", seconds.compare_seconds)):
        assert study(plan).name == name

    (tmp_path / "circles" / "robot-sparse-5-seed-0.mcap").write_bytes(b"spoilt")
    with pytest.raises(ScanError, match="robot-sparse-5-seed-0"):
        run_all(plan)


def fake(what, method, seed, error, dense=False, seconds=2.0):
    view = {"status": "ok", "translation_error_m": error, "rotation_error_chordal": error, "center_error_m": error}
    views = [
        {"view": i} | {key: value if i or key == "status" else 0.0 for key, value in view.items()} for i in range(3)
    ]
    circle = Circle(what, 3, seed, dense)
    return Run(circle, method, views, {}, {"registration": seconds, "outlier_removal": 0.5})


@pytest.fixture
def faked(monkeypatch):
    """Runs in which RANSAC helps the bin and harms the robot, and ICP takes twice as long."""
    levels = {"icp": 0.2, "ransac_icp": 0.1, "pairwise": 0.01, "refined": 0.001}

    def run_all(plan):
        return [
            fake(
                what,
                method,
                seed,
                levels.get(method, 0.05) * (3 if (what, method) == ("robot", "ransac_icp") else 1),
                dense,
                4.0 if method == "icp" else 2.0,
            )
            for dense in (False, True)
            for seed in (plan.seeds if not dense else (0,))
            for what in run.OBJECTS
            for method in METHODS
        ]

    monkeypatch.setattr(run, "run_all", run_all)


@pytest.mark.usefixtures("faked")
def test_the_claim_is_judged_object_by_object(tmp_path):
    report = errors.compare_errors(Plan(tmp_path, runs=3))
    claims = {claim.text: claim for claim in report.claims}
    assert claims["RANSAC before ICP makes the largest rotation error of the bin smaller"].verdict == "holds"
    assert claims["RANSAC before ICP makes the largest rotation error of the robot smaller"].verdict == "does not hold"
    (row,) = (r for r in report.rows if (r["object"], r["method"], r["part"]) == ("bin", "icp", "20 degrees apart"))
    assert (row["max_translation_mm"], row["max_chordal"], row["runs"]) == pytest.approx((200, 0.2, 3))
    assert row["last_chordal"] == pytest.approx(0.2)
    over_all = claims["RANSAC before ICP makes the largest rotation error smaller, 20 degrees apart"]
    assert (over_all.verdict, over_all.runs) == ("cannot be told", 5)
    assert over_all.difference == pytest.approx(30)  # 4 halved, one half as much more
    assert over_all.evidence.endswith("5 paired objects")
    assert "differ by more than a tenth in 30 of 30 views 20 degrees apart, in 10 of 10 views 1.44" in report.said[0]
    assert set(report.figures) == {"figure-5.8", "figure-5.8-all"}


@pytest.mark.usefixtures("faked")
def test_seconds_are_stacked_by_object(tmp_path):
    report = seconds.compare_seconds(Plan(tmp_path, runs=2))
    assert len(report.rows) == 2 * 5 * 2
    assert "bin 0.50" in report.said[0]
    axes = report.figures["figure-5.10"].axes[0]
    heights = [bar.get_height() for container in axes.containers[:2] for bar in container]
    assert heights == pytest.approx([4.0, 0.5])


def test_a_view_without_estimate_is_no_error_but_counts():
    run = fake("bin", "icp", 0, 0.5)
    run.views[2].update(status="no_consensus", translation_error_m=None, center_error_m=None)
    assert run.errors("center_error_m") == [0.5]
    assert np.isnan(errors.curves([run], "center_error_m")[0, 1])
    assert run.unplaced == 1


@pytest.mark.usefixtures("faked")
def test_methods_are_compared_on_the_views_that_both_placed(tmp_path, monkeypatch):
    runs = run.run_all(Plan(tmp_path, runs=3))
    for found in runs:
        if found.method == "icp" and found.circle.what in ("bin", "statue"):
            found.views[2].update(translation_error_m=9.0, rotation_error_chordal=2.0)
        lost = {"bin": [2], "statue": [1, 2]}.get(found.circle.what, []) if found.method == "ransac_icp" else []
        for view in lost:  # a method gains nothing from leaving out the view where the other is worst
            found.views[view].update(status="no_consensus", translation_error_m=None, rotation_error_chordal=None)
    monkeypatch.setattr(run, "run_all", lambda plan: runs)
    report = errors.compare_errors(Plan(tmp_path, runs=3))
    (of_bin,) = (claim for claim in report.claims if "largest rotation error of the bin" in claim.text)
    assert "difference +0.1 chordal" in of_bin.evidence
    (of_statue,) = (claim for claim in report.claims if "largest rotation error of the statue" in claim.text)
    assert str(of_statue).endswith("cannot be told (no view has an estimate by both methods).")
    row = next(r for r in report.rows if (r["object"], r["method"]) == ("statue", "ransac_icp"))
    assert (row["unplaced_views"], row["failed_views"], row["max_chordal"]) == (2, 2, None)
