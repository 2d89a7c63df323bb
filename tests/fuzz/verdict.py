"""What must be true of what comes out of a damaged recording, and is not."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.recorder.session import Session, SessionInfo
from tests.fuzz.commands import LIMIT_S, Ended
from tests.fuzz.original import VIEWS, Original, Whole

LOST_FACTS = SessionInfo(name="damaged", views=VIEWS, sensor_origin=None)  # what is assumed where nothing is known


@dataclass(frozen=True)
class Usual:
    """How `process` is run, and its results.json for the undamaged recording."""

    options: tuple[str, ...]
    results: dict[str, Any]


def judge_end(end: Ended) -> Iterator[str]:
    """What is wrong with how a command ended."""
    if end.broke:
        yield end.broke
    elif end.status not in (0, 1, 2):
        yield f"ends with {end.status}"
    elif end.status == 2 and not (end.err.startswith("orbitscan: error: ") and end.err.count("\n") == 1):
        yield f"ends with 2 and says {end.err!r}"
    if end.seconds > LIMIT_S:
        yield f"takes {end.seconds:.1f} s"


def judge_session(session: Session, original: Original, whole: Whole) -> tuple[set[int], list[str]]:
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


def judge_commands(
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
