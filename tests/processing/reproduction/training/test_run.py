"""A run is the thesis's training, told by its scores, its curve and its confusion matrix."""

import numpy as np
import pytest

from orbitscan.processing.classification.labelled_views import gather
from orbitscan.processing.classification.training import THESIS
from orbitscan.processing.classification.voxels import VoxelSettings
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.training import data, run
from orbitscan.processing.reproduction.training.run import BEST, CURVE, Training, run_trainings, train_once
from tests.processing.classification import toys
from tests.processing.reproduction import fakes

SMALL = {"structure": "C(4,3,2)-P(2)-FC(3)", "voxels": VoxelSettings(12)}


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    views = gather(toys.sessions())
    path = tmp_path_factory.mktemp("data") / "views.npz"
    data.save(views, path, "toys")
    return data.Data(path, views.fingerprint)


def test_a_run_tells_what_the_test_views_reach(found):
    result = train_once(Training(found, run.change_thesis(SMALL), seed=1, curve=2))
    views = data.load(found)
    confusion = np.array(result["confusion"])
    assert confusion.sum() == len(data.split(views).validation)
    assert result["accuracy"] == pytest.approx(np.trace(confusion) / confusion.sum())
    assert result["overfitting"] == pytest.approx(result["loss"] - result["train_loss"])
    assert result["curve"]["validation_loss"][-1] == pytest.approx(result["loss"])
    assert len(result["curve"]["step"]) <= 2 * THESIS.epochs


def test_a_seed_tells_the_whole_run(found):
    one, again, two = (train_once(Training(found, run.change_thesis(SMALL), seed)) for seed in (1, 1, 2))
    assert (one["loss"], one["confusion"]) == (again["loss"], again["confusion"])
    assert one["loss"] != two["loss"]


def test_runs_come_by_change_in_the_order_of_the_seeds(monkeypatch, tmp_path):
    asked = []

    def keep(plan, work, tasks, what):
        asked.extend(tasks)
        return [fakes.run(task.seed, loss=task.settings.epochs) for task in tasks]

    monkeypatch.setattr(run, "keep", keep)
    monkeypatch.setattr(data, "provide", lambda plan: data.Data(tmp_path, "0"))
    plan = Plan(tmp_path, runs=3, precision="bfloat16")
    changes = {"best": {"epochs": 5}, "flat": {"epochs": 7, "structure": "FC(10)"}}
    runs = run_trainings(plan, changes, "Training")
    assert list(runs) == ["best", "flat"]
    first, second = runs.values()
    assert [(run["accuracy"], run["loss"]) for run in first] == [(0, 5), (1, 5), (2, 5)]
    assert [(run["accuracy"], run["loss"]) for run in second] == [(0, 7), (1, 7), (2, 7)]
    assert {(task.settings.structure, task.curve) for task in asked} == {(BEST, CURVE), ("FC(10)", 0)}
    assert {task.settings.precision for task in asked} == {"bfloat16"}
    assert "/" not in str([task.key for task in asked])  # no paths


def test_the_same_training_is_the_same_run_for_every_study(found):
    tasks = [Training(found, run.change_thesis(change), 0) for change in ({}, {"structure": BEST}, {"init": "dcae"})]
    assert tasks[0].key == tasks[1].key != tasks[2].key
