"""Runs that are kept: each one's result is a file, and what is finished is not done again."""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

from orbitscan.processing.reproduction.plan import Plan
from orbitscan.recorder.atomic import write_whole
from orbitscan.recorder.workers import as_ready


class Task(Protocol):
    """What a run depends on, and nothing else: equal tasks are done once, whichever study asks."""

    @property
    def name(self) -> str:
        """The readable part of the name of the run's file."""

    @property
    def key(self) -> dict[str, Any]:
        """All that the result depends on, as JSON holds it; no paths."""


Work = Callable[[Any], dict[str, Any]]


def keep(plan: Plan, work: Work, tasks: Sequence[Task], what: str) -> list[dict[str, Any]]:
    """Do the tasks by `work`, a function that other processes can import, and return each one's result in their order.

    A finished run is read from `FOLDER/runs`; others are worked on with one thread each, `plan.workers` at a time, and
    written as soon as they are done: a stopped study loses the runs in flight.
    """
    folder = plan.folder / "runs"
    missing = {_path(folder, task): task for task in tasks if _read(_path(folder, task), task) is None}
    for _ in plan.progress(_work_on(missing, work, plan.workers), len(missing), what) if missing else ():
        pass
    results = [_read(_path(folder, task), task) for task in tasks]
    assert all(result is not None for result in results)
    return results  # type: ignore[return-value]


def _work_on(missing: dict[Path, Task], work: Work, workers: int) -> Iterator[Path]:
    workers = min(workers, len(missing))
    if workers == 1:
        yield from (_finish(work, item) for item in missing.items())
        return
    for _, finished in as_ready(partial(_finish, work), missing.items(), workers):
        yield finished.result()


def _finish(work: Work, item: tuple[Path, Task]) -> Path:
    """Do a task and keep its result; on one thread: a sum in another order might differ in its last bit."""
    import numba
    import torch

    path, task = item
    threads = torch.get_num_threads(), numba.get_num_threads()
    torch.set_num_threads(1)
    numba.set_num_threads(1)
    try:
        result = work(task)
    finally:
        torch.set_num_threads(threads[0])
        numba.set_num_threads(threads[1])
    write_whole(path, json.dumps({"key": _key(task), "result": result}, indent=1) + "\n")
    return path


def _read(path: Path, task: Task) -> dict[str, Any] | None:
    """A finished run's result; None where it is missing, of another key, or cannot be read."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        return content["result"] if content["key"] == _key(task) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _key(task: Task) -> dict[str, Any]:
    return json.loads(json.dumps({"orbitscan": version("orbitscan")} | task.key))  # a tuple is read back as a list


def _path(folder: Path, task: Task) -> Path:
    return folder / f"{task.name}-{digest(_key(task))}.json"


def digest(key: dict[str, Any]) -> str:
    """Twelve digits, for the name of a file, that tell a key from others."""
    return hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:12]
