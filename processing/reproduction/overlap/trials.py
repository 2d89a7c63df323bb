"""The trials of the overlap study: which succeed, which of them are asked for, and how often those succeed."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

from orbitscan.processing.reproduction.claims import CONFIDENCE
from orbitscan.processing.reproduction.overlap.run import Pairs

MOST_DEG, MOST_SHARE = 5.0, 0.05  # a pose farther off, in degrees or diameters, is wrong
OVERLAPS = ((0, 20), (20, 40), (40, 60), (60, 80), (80, 100))  # per cent

Trial = dict[str, Any]


def collect(results: Sequence[dict[str, Any]], tasks: Sequence[Pairs]) -> list[Trial]:
    """The trials of all tasks, each with its object, azimuth, run and overlap, and judged."""
    return [
        {"object": task.what, "azimuth_deg": task.azimuth_deg, "run": task.seed, "overlap": result["overlap"]}
        | trial
        | judge(trial, result["diameter_m"])
        for task, result in zip(tasks, results, strict=True)
        for trial in result["trials"]
    ]


def judge(trial: Trial, diameter: float) -> dict[str, bool]:
    """Whether a trial succeeds, and whether it is `ok` but wrong beyond the motions that it declares free."""
    observable = _near(trial["observable_deg"], trial["observable_m"], diameter)
    return {
        "success": _near(trial["error_deg"], trial["error_m"], diameter),
        "ok_but_wrong": trial["status"] == "ok" and not observable,
    }


def _near(degrees: float | None, metres: float | None, diameter: float) -> bool:
    return degrees is not None and metres is not None and degrees <= MOST_DEG and metres <= MOST_SHARE * diameter


def choose(trials: Sequence[Trial], **values: Any) -> list[Trial]:
    """The trials that have all the given values."""
    return [trial for trial in trials if all(trial[key] == value for key, value in values.items())]


def within(trials: Sequence[Trial], low: int, high: int) -> list[Trial]:
    """The trials whose overlap [%] lies from `low` to below `high`; 100 belongs to the highest interval."""
    return [trial for trial in trials if low <= 100 * trial["overlap"] < (high if high < 100 else np.inf)]


def mean(trials: Sequence[Trial], key: str) -> float:
    """The mean of one of the trials' numbers."""
    return float(np.mean([trial[key] for trial in trials]))


def interval(trials: Sequence[Trial]) -> tuple[float, float]:
    """Wilson's interval of the success [%], the trials taken for independent."""
    successes = sum(trial["success"] for trial in trials)
    found = binomtest(successes, len(trials)).proportion_ci(CONFIDENCE, method="wilson")
    return 100 * found.low, 100 * found.high
