"""One training of a study, and what it reaches on the test views: the run that most of chapter 5 is made of."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from orbitscan.processing.classification.evaluation import EpochRecord, StepRecord
from orbitscan.processing.classification.network import BODY
from orbitscan.processing.classification.training import THESIS, TrainingSettings, train
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.runs import keep
from orbitscan.processing.reproduction.training import data
from orbitscan.processing.reproduction.training.data import Data

Runs = dict[str, list[dict[str, Any]]]  # the results of several runs, by name
BEST = f"{BODY}-FC(10)"  # of table 5.1
CURVE = 50  # points of an epoch's curve: figure 5.2 has 100 of two epochs, figure 5.4 150 of three


@dataclass(frozen=True)
class Training:
    """A training: what it learns from and how."""

    data: Data
    settings: TrainingSettings
    seed: int
    device: str = "cpu"
    curve: int = 0

    @property
    def name(self) -> str:
        """The name of its file."""
        how = self.settings
        side = "-orientation" if how.orientation else ""
        return f"{how.init}-{how.voxels.values}{side}-{how.epochs}-epochs-seed-{self.seed}"

    @property
    def key(self) -> dict[str, Any]:
        """All that its result depends on, as JSON holds it."""
        return {
            "views": self.data.fingerprint,
            "settings": asdict(self.settings),
            "seed": self.seed,
            "device": self.device.split(":")[0],
            "curve": self.curve,
        }


def train_once(task: Training) -> dict[str, Any]:
    """Do a training: its scores after the last epoch, its curve, the confusion matrix and the seconds it took."""
    views = data.load(task.data)
    started = time.perf_counter()
    records = list(train(views, data.split(views), task.settings, seed=task.seed, device=task.device, curve=task.curve))
    seconds = time.perf_counter() - started
    *_, last = (record for record in records if isinstance(record, EpochRecord))
    steps = [asdict(record) for record in records if isinstance(record, StepRecord)]
    return {
        "accuracy": last.validation_accuracy,
        "loss": last.validation_loss,
        "train_accuracy": last.train_accuracy,
        "train_loss": last.train_loss,
        "overfitting": last.overfitting,
        "confusion": last.confusion,
        "views_per_second": last.views_per_second,
        "seconds": seconds,
        "curve": {key: [step[key] for step in steps] for key in steps[0]} if steps else {},
    }


def change_thesis(change: Mapping[str, Any]) -> TrainingSettings:
    """The settings of the thesis's training of its best structure, with the given ones changed."""
    return replace(THESIS, **({"structure": BEST} | dict(change)))


def run_trainings(plan: Plan, changes: Mapping[str, dict[str, Any]], what: str) -> Runs:
    """The results of all runs for each change of the thesis's settings, in the order of the plan's seeds.

    The best structure's runs have their curve, so that all studies share them.
    """
    found = data.provide(plan)
    settings = [change_thesis({"precision": plan.precision} | change) for change in changes.values()]
    ways = [(how, CURVE if how.structure == BEST else 0) for how in settings]
    tasks = [Training(found, how, seed, plan.device, curve) for seed in plan.seeds for how, curve in ways]
    results = keep(plan, train_once, tasks, what)
    return {name: results[i :: len(settings)] for i, name in enumerate(changes)}


def column(runs: Sequence[dict[str, Any]], key: str, factor: float = 1.0) -> list[float]:
    """One of the numbers of every run, times a factor."""
    return [factor * run[key] for run in runs]


def average(runs: Sequence[dict[str, Any]], key: str, factor: float = 1.0) -> float:
    """The mean over the runs of one of their numbers, times a factor."""
    return float(np.mean(column(runs, key, factor)))


def curves(named: Runs, key: str, factor: float = 1.0) -> dict[str, np.ndarray]:
    """One of the curves of every run, (runs, steps), by name, times a factor."""
    return {name: factor * np.array([run["curve"][key] for run in runs]) for name, runs in named.items()}


def tabulate_runs(named: Runs, label: str) -> list[dict[str, Any]]:
    """A row for each run: its scores on the test views."""
    return [
        {
            label: name,
            "run": i,
            "accuracy_percent": 100 * run["accuracy"],
            **{key: run[key] for key in ("loss", "train_loss", "overfitting", "seconds")},
        }
        for name, runs in named.items()
        for i, run in enumerate(runs)
    ]


def tabulate_curves(named: Runs, label: str) -> list[dict[str, Any]]:
    """A row for each point of each curve, the mean of the runs."""
    return [
        {label: name, "step": step, "accuracy_percent": 100 * accuracy, "loss": loss, "overfitting": loss - train_loss}
        for name, runs in named.items()
        for step, accuracy, loss, train_loss in zip(
            runs[0]["curve"]["step"],
            *(
                np.mean([run["curve"][key] for run in runs], axis=0).tolist()
                for key in ("validation_accuracy", "validation_loss", "train_loss")
            ),
            strict=True,
        )
    ]
