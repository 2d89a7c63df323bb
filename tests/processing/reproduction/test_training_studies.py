"""The studies of trainings: means over the runs, the thesis's numbers beside them, and what is claimed."""

import numpy as np
import pytest

from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.training import counts, data, initializations, orientation, structures
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.simulation import corpus
from tests.processing.reproduction import fakes


@pytest.fixture
def plan(tmp_path):
    return Plan(tmp_path, runs=4)


def verdicts(report):
    return {claim.text: claim.verdict for claim in report.claims}


def test_table_5_1_has_the_seven_structures_beside_the_thesis(plan, monkeypatch):
    asked = fakes.stub(monkeypatch, structures, [0.5, 0.5, 0.6, 0.5, 0.9, 0.95, 0.5])
    report = structures.compare_structures(plan)
    assert [change["structure"] for change in asked] == [row["structure"] for row in report.rows]
    assert len(report.rows) == 7
    best = report.rows[4]
    assert best["accuracy_percent"] == pytest.approx(90.5)
    assert (best["thesis_accuracy_percent"], best["thesis_loss"]) == (92.21, 0.2759)
    assert "C(64,3,2)-C(32,3)-P(2)-C(32,3)-P(2)-FC(10), 95.50 %" in report.said[0]
    assert list(verdicts(report).values()) == ["holds", "holds", "holds", "holds", "does not hold", "holds"]


def test_table_5_4_tells_which_initialization_is_better(plan, monkeypatch):
    asked = fakes.stub(monkeypatch, initializations, [0.8, 0.7, 0.9, 0.8])
    report = initializations.tabulate(plan)
    assert [change["init"] for change in asked] == ["glorot", "dcae", "kmeans-pca", "kmeans-zca"]
    assert [row["thesis_loss"] for row in report.rows] == [0.2825, 0.2221, 0.1984, 0.2713]
    found = verdicts(report)
    assert found["PCA is more accurate than Glorot"] == "holds"
    assert found["DCAE is more accurate than Glorot"] == "does not hold"
    assert found["ZCA is more accurate than Glorot"] == "cannot be told"
    assert found["PCA has less overfitting than Glorot"] == "cannot be told"


def test_figure_5_1_has_a_row_for_each_run(plan, monkeypatch):
    fakes.stub(monkeypatch, initializations, [0.8, 0.7, 0.9, 0.8])
    report = initializations.draw_boxes(plan)
    assert len(report.rows) == 16
    assert report.rows[5]["accuracy_percent"] == pytest.approx(71)
    assert "by up to 1.0 points" in report.said[0]
    assert "differ by 20.0 points" in report.said[0]


def test_figure_5_2_has_the_mean_curves(plan, monkeypatch):
    fakes.stub(monkeypatch, initializations, [0.8, 0.7, 0.9, 0.8])
    report = initializations.draw_curves(plan)
    last = [row for row in report.rows if row["step"] == 4]
    assert [row["accuracy_percent"] for row in last] == pytest.approx([80.5, 70.5, 90.5, 80.5])
    assert [row["overfitting"] for row in report.rows] == pytest.approx([0.3] * 16)
    assert report.said[0].split("first: ")[1].startswith("PCA")
    axes = report.figures["figure-5.2"].axes
    assert [a.get_ylabel() for a in axes] == [
        "accuracy of test views [%]",
        "loss of test views [nats]",
        "overfitting [nats]",
    ]
    assert [len(a.lines) for a in axes] == [4, 4, 4]


def test_counts_are_held_against_occupancy(plan, monkeypatch):
    asked = fakes.stub(monkeypatch, counts, [0.9, 0.8])
    report = counts.compare_values(plan)
    assert [change["voxels"] for change in asked] == [VoxelSettings(values="counts"), VoxelSettings(values="occupancy")]
    assert verdicts(report)["Counts are more accurate than occupancy"] == "holds"


@pytest.fixture
def turning(plan, monkeypatch):
    """Views whose place on the turn is known, or not."""

    class Views:
        turns = np.array([0.0, 0.5])
        names = tuple(corpus.INSTANCES)

    monkeypatch.setattr(data, "provide", lambda plan: None)
    monkeypatch.setattr(data, "load", lambda found: Views)
    return Views


def test_the_orientation_head_is_trained_for_three_epochs(plan, monkeypatch, turning):
    asked = fakes.stub(monkeypatch, orientation, [0.8, 0.9])
    report = orientation.draw_boxes(plan)
    assert asked == [{"epochs": 3, "orientation": False}, {"epochs": 3, "orientation": True}]
    assert verdicts(report)["With the orientation the category is told more accurately"] == "holds"
    assert len(orientation.draw_curves(plan).rows) == 8


def test_confusions_are_summed_over_the_runs(plan, monkeypatch, turning):
    fakes.stub(monkeypatch, orientation, [0.8, 0.9])
    report = orientation.draw_confusions(plan)
    assert len(report.rows) == 20
    assert (report.rows[0]["as_apple"], report.rows[0]["as_bell_pepper"]) == (400, 12)
    assert report.said[0] == "Without orientation: most often confused is apple with bell_pepper, 3 % of its views."


def test_views_of_unknown_place_have_no_orientation(plan, turning):
    turning.turns = np.array([np.nan, np.nan])
    with pytest.raises(InvalidOption, match="where a turn ends"):
        orientation.draw_boxes(plan)
