"""One damaged recording through `info`, `check` and `process`: what must be true of what comes out."""

import contextlib
import faulthandler
import io
import json
import shutil
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from processing.cli import app
from recorder import mcap_file
from recorder.cli import run
from recorder.exceptions import UnreadableRecording
from recorder.session import Session, SessionInfo
from tests.fuzz.mutations import mutate
from tests.fuzz.original import VIEWS, Original, Whole, find_whole

LIMIT_S = 10.0
LOST_FACTS = SessionInfo(name="damaged", views=VIEWS, sensor_origin=None)  # what is assumed where nothing is known


class TooSlow(BaseException):
    """A command took longer than its limit; no `except Exception` may hold it back."""


@dataclass(frozen=True)
class Trial:
    """What became of one damaged recording."""

    number: int
    kinds: list[str]
    what: str
    outcome: str  # whole, part or refused
    views: tuple[int, int]  # whole in the file, and come out
    seconds: float  # of the slowest command
    complaints: list[str]


@dataclass(frozen=True)
class Usual:
    """How `process` is run, and its results.json for the undamaged recording."""

    options: tuple[str, ...]
    results: dict[str, Any]


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    status: int | None  # None where it broke
    out: str
    err: str
    seconds: float
    broke: str = ""


def run_trial(original: Original, number: int, folder: Path, usual: Usual) -> Trial:
    """Damage the recording by the number, run the commands on it in a folder, and look at all that comes out."""
    damaged, kinds, what = mutate(original.content, number)
    whole = find_whole(original, damaged)
    path, results = folder / "damaged.mcap", folder / "results"
    path.write_bytes(damaged.values.tobytes())
    shutil.rmtree(results, ignore_errors=True)
    ended = {
        "info": run_command("info", str(path)),
        "check": run_command("check", str(path)),
        "process": run_command("process", str(path), "-o", str(results), *usual.options),
    }
    complaints = [f"{name}: {complaint}" for name, end in ended.items() for complaint in _judge_end(end)]
    try:
        session = mcap_file.read(path)
    except UnreadableRecording as refusal:
        complaints += [f"{name} ends with {end.status}" for name, end in ended.items() if end.status != 2]
        if whole.views and whole.either_end:
            complaints.append(f"refused, with {sorted(whole.views)} whole: {refusal}")
        seconds = max(end.seconds for end in ended.values())
        return Trial(number, kinds, what, "refused", (len(whole.views), 0), seconds, complaints)
    readable, found = _judge_session(session, original, whole)
    complaints += found
    complaints += _judge_commands(ended, session, readable, results / "damaged", original, whole, usual)
    seconds = max(end.seconds for end in ended.values())
    outcome = "whole" if len(readable) == VIEWS else "part"
    return Trial(number, kinds, what, outcome, (len(whole.views), len(readable)), seconds, complaints)


def process_undamaged(original: Original, folder: Path, options: Sequence[str] = ()) -> Usual:
    """What `process` finds for the undamaged recording."""
    path = folder / "undamaged.mcap"
    path.write_bytes(original.content)
    end = run_command("process", str(path), "-o", str(folder / "usual"), *options)
    assert end.status == 0, end
    return Usual(tuple(options), json.loads((folder / "usual" / "undamaged" / "results.json").read_text()))


def run_command(*arguments: str) -> Ended:
    """Run a command in this process, but no longer than the limit."""
    out, err = io.StringIO(), io.StringIO()
    status, broke, started = None, "", time.perf_counter()
    try:
        with _no_longer_than(LIMIT_S), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            run(app, list(arguments))
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except (Exception, TooSlow):
        broke = traceback.format_exc()
    return Ended(status, out.getvalue(), err.getvalue(), time.perf_counter() - started, broke)


@contextlib.contextmanager
def _no_longer_than(seconds: float) -> Iterator[None]:
    """Raise TooSlow in what takes longer; end the process, with all stacks shown, where even that does not help."""

    def interrupt(*_: object) -> None:
        raise TooSlow

    faulthandler.dump_traceback_later(3 * seconds, exit=True, file=sys.__stderr__)
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, interrupt)
        signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)
        faulthandler.cancel_dump_traceback_later()


def _judge_end(end: Ended) -> Iterator[str]:
    if end.broke:
        yield end.broke
    elif end.status not in (0, 1, 2):
        yield f"ends with {end.status}"
    elif end.status == 2 and not (end.err.startswith("orbitscan: error: ") and end.err.count("\n") == 1):
        yield f"ends with 2 and says {end.err!r}"
    if end.seconds > LIMIT_S:
        yield f"takes {end.seconds:.1f} s"


def _judge_session(session: Session, original: Original, whole: Whole) -> tuple[set[int], list[str]]:
    """The views that can be read, and what is wrong with what is read."""
    wrong: list[str] = []
    readable = set()
    facts, told = original.session.info, session.damage is not None
    for field in fields(SessionInfo):
        value, right = getattr(session.info, field.name), getattr(facts, field.name)
        if value != right and (whole.facts or value != getattr(LOST_FACTS, field.name)) and field.name != "views":
            wrong.append(f"{field.name} is {value!r}, not {right!r}")
    if session.info != facts and not told:
        wrong.append("facts are lost without a word")
    if whole.views and session.info.views < max(whole.views) + 1:
        wrong.append(f"{session.info.views} views")
    if session.info.views > VIEWS or (whole.facts and session.info.views != VIEWS):
        wrong.append(f"{session.info.views} views")
    for view in session.views():
        if view.index >= VIEWS:
            continue
        right = original.session.load(view.index)
        if view.name not in (right.name, f"view_{view.index:03d}") or (whole.names and view.name != right.name):
            wrong.append(f"view {view.index} is called {view.name!r}")
        if view.name != right.name and not told:
            wrong.append("names are lost without a word")
        if view.damage is None:
            readable.add(view.index)
            if not (
                np.array_equal(view.points, right.points)
                and np.array_equal(view.colors, right.colors)
                and view.stamp_ns == right.stamp_ns
            ):
                wrong.append(f"view {view.index} holds other points, without a word")
        elif view.index in whole.views:
            wrong.append(f"view {view.index} is whole and {view.damage}")
    truth, right_truth = session.truth(), original.session.truth()
    wrong += [f"the pose of view {view} is lost" for view in whole.poses - set(truth)]
    for view, T in truth.items():
        if view not in right_truth or not np.array_equal(T, right_truth[view]):
            wrong.append(f"the pose of view {view} is wrong")
    return readable, wrong


def _judge_commands(
    ended: dict[str, Ended],
    session: Session,
    readable: set[int],
    folder: Path,
    original: Original,
    whole: Whole,
    usual: Usual,
) -> Iterator[str]:
    """What is wrong with what the commands say of a recording that can be read."""
    lost = set(range(session.info.views)) - readable
    if ended["info"].status != 0:
        yield f"info ends with {ended['info'].status}"
    if lost and "none" in ended["info"].out.rsplit("damage", 1)[-1]:
        yield f"info says nothing of the views {sorted(lost)}"
    damaged = bool(lost) or session.damage is not None
    if damaged and ended["check"].status != 1:
        yield f"check ends with {ended['check'].status}, with damage"
    if ended["process"].status == 2 and readable:
        yield f"process refuses: {ended['process'].err}"
    if ended["process"].status == 2 or ended["process"].broke:
        return
    if damaged and (ended["process"].status != 1 or not ended["process"].err):
        yield f"process ends with {ended['process'].status} and says {ended['process'].err!r}, with damage"
    found = json.loads((folder / "results.json").read_text())
    for method, result in found["reconstruction"].items():
        unreadable = {view["view"] for view in result["views"] if view["status"] == "unreadable"}
        if unreadable != lost:
            yield f"process calls the views {sorted(unreadable)} unreadable by {method}, not {sorted(lost)}"
    if len(readable) == VIEWS and session.info == original.session.info and whole.poses == set(range(VIEWS)):
        for part in ("reconstruction", "classification", "model", "turntable"):
            if found[part] != usual.results[part]:
                yield f"process finds another {part}"
