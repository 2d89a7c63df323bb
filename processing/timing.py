"""Where the seconds go: per stage, and per method that uses the stage."""

import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from orbitscan.processing.results.status import METHODS

SESSION = "session"  # in a method's place: what is done once, whatever the methods
STAGES = ("prepare", "keypoints", "descriptors", "matching", "ransac", "icp", "refine")
FEATURE_METHODS = ("ransac_icp", "pairwise", "refined")  # those that use keypoints
_USERS = {"prepare": METHODS, "refine": ("pairwise", "refined")}  # of a shared stage; of the others: FEATURE_METHODS


class Stopwatch:
    """Seconds by method and stage; a shared stage counts in every method that uses it.

    Where one stage runs inside another, its seconds are its own and not the outer one's.
    """

    def __init__(self, methods: Sequence[str] = METHODS) -> None:
        self._methods = tuple(methods)
        self._started = time.perf_counter()
        self._inside: list[float] = []  # of each running stage, outermost first: seconds of finished stages inside it
        self._seconds: defaultdict[str, defaultdict[str, float]] = defaultdict(lambda: defaultdict(float))

    @contextmanager
    def __call__(self, stage: str, *methods: str) -> Iterator[None]:
        """Time a stage, for these methods."""
        started = time.perf_counter()
        self._inside.append(0.0)
        try:
            yield
        finally:
            elapsed = time.perf_counter() - started
            own = elapsed - self._inside.pop()
            if self._inside:
                self._inside[-1] += elapsed
            for method in methods:
                self._seconds[method][stage] += own

    def shared(self, stage: str) -> AbstractContextManager[None]:
        """Time a stage, for all methods of this watch that use it."""
        return self(stage, *(method for method in self._methods if method in _USERS.get(stage, FEATURE_METHODS)))

    @contextmanager
    def alone(self, stage: str, method: str) -> Iterator[None]:
        """Time a stage for one method, and all shared stages inside it for that method alone."""
        methods, self._methods = self._methods, (method,)
        try:
            with self(stage, method):
                yield
        finally:
            self._methods = methods

    @property
    def elapsed(self) -> float:
        """Seconds since it was made."""
        return time.perf_counter() - self._started

    def lap(self) -> dict[str, dict[str, float]]:
        """Method -> stage -> seconds since the last lap."""
        seconds = {method: dict(stages) for method, stages in self._seconds.items()}
        self._seconds.clear()
        return seconds


def total(laps: Sequence[Mapping[str, Mapping[str, float]]], methods: Sequence[str], elapsed: float) -> dict[str, Any]:
    """The content of timings.json: seconds per method and stage over all laps, of the session, and in all."""

    def seconds(method: str, stage: str) -> float:
        return sum(lap.get(method, {}).get(stage, 0.0) for lap in laps)

    sums = {method: {stage: seconds(method, stage) for stage in STAGES} for method in methods}
    timings = {method: {**stages, "total": sum(stages.values())} for method, stages in sums.items()}
    of_session = {stage: seconds(SESSION, stage) for stage in ("outlier_removal", "classification")}
    return {"methods": timings, **of_session, "total": elapsed}
