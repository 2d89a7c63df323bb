"""Table 5.3: the network from four initialisations against four descriptors, by accuracy and by seconds."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from processing.classification.descriptor_matching import KINDS
from processing.reproduction import data, drawing, initialisations
from processing.reproduction.claims import compare
from processing.reproduction.descriptor_runs import KNOWN, TESTED, Learning, Matching, choose, learn_once, match_once
from processing.reproduction.initialisations import NAMES
from processing.reproduction.plan import Plan
from processing.reproduction.report import Report
from processing.reproduction.runs import keep
from processing.reproduction.training_run import change_thesis, column

THESIS = {  # accuracy [%], seconds for TESTED views
    "shot": (91.77, 175.0),
    "fpfh": (87.55, 240.0),
    "pfh": (89.87, 6049.0),
    "esf": (83.54, 15.0),
}
THESIS_NETWORK_S = 0.1  # at most, on a GPU
CONTROL = f"Glorot, {KNOWN} views each"  # the network on what the descriptors know
Runs = dict[str, list[dict[str, Any]]]
_STAR = {"linestyle": "", "marker": "*", "markersize": 10, "color": "black", "markeredgecolor": "white"}


def compare_descriptors(plan: Plan) -> Report:
    """Accuracy and seconds of each way to name a view."""
    networks = {NAMES[init]: runs for init, runs in initialisations.run_all(plan).items()}
    matched = _match_all(plan)
    control = matched.pop(CONTROL)
    seconds = float(np.median(column(control, "seconds")))
    tested = control[0]["tested"]
    rows = [
        {
            "classifier": name,
            "known_views": "all of training",
            "accuracy_percent": _mean(runs, "accuracy", 100),
            "thesis_accuracy_percent": initialisations.THESIS[init][0],
            f"seconds_for_{TESTED}": seconds * TESTED / tested,
            "thesis_seconds": f"< {THESIS_NETWORK_S} (GPU)",
        }
        for (name, runs), init in zip(networks.items(), NAMES, strict=True)
    ]
    rows += [
        {
            "classifier": name,
            "known_views": str(runs[0]["known"]),
            "accuracy_percent": _mean(runs, "accuracy", 100),
            "thesis_accuracy_percent": THESIS[name.lower()][0] if name != CONTROL else None,
            f"seconds_for_{TESTED}": _mean(runs, "seconds") * TESTED / tested,
            "thesis_seconds": f"{THESIS[name.lower()][1]:.0f}" if name != CONTROL else None,
        }
        for name, runs in (matched | {CONTROL: control}).items()
    ]
    scaled = "" if tested == TESTED else f"; the seconds are scaled to {TESTED}"
    said = [
        f"The descriptors know {control[0]['known']} views, {KNOWN} of each category at most, drawn anew for each run; "
        "the networks learn from all training views, and their accuracy is of all test views. "
        f"{tested} views are named, on one thread{scaled}.",
        *_claim(networks, matched, control),
        _rank(rows),
    ]
    return Report(
        "table-5.3",
        "Networks against descriptors",
        rows,
        said,
        {"table-5.3": _draw(networks | matched | {CONTROL: control}, rows)},
        {"known_views_of_a_category": KNOWN, "tested_views": tested, "threads": 1},
    )


def _match_all(plan: Plan) -> Runs:
    """The runs of each descriptor, and of the network that learns from the same few views."""
    found = data.provide(plan)
    every = 1 if plan.dataset is None else plan.every  # a virtual circle is recorded thinned
    sessions = data.open_circles(plan)
    choices = [choose(sessions, every, seed) for seed in plan.seeds]
    runs: Runs = {}
    for kind in KINDS:
        tasks = [Matching(kind, found, *choice, seed) for choice, seed in zip(choices, plan.seeds, strict=True)]
        runs[kind.upper()] = keep(plan, match_once, tasks, f"Matching {kind.upper()}")
    how = change_thesis({"precision": plan.precision})
    learning = [
        Learning(found, *choice, how, seed, plan.device) for choice, seed in zip(choices, plan.seeds, strict=True)
    ]
    runs[CONTROL] = keep(plan, learn_once, learning, "Training on the descriptors' views")
    return runs


def _claim(networks: Runs, matched: Runs, control: Sequence[dict[str, Any]]) -> list[str]:
    accuracy = {name: column(runs, "accuracy", 100) for name, runs in (networks | matched).items()}
    order = sorted(matched, key=lambda name: -THESIS[name.lower()][0])
    claims = [
        compare(f"The network from {name} is more accurate than SHOT", accuracy[name], accuracy["SHOT"], "points")
        for name in networks
    ]
    claims += [
        compare(f"{better} is more accurate than {worse}", accuracy[better], accuracy[worse], "points")
        for better, worse in pairwise(order)
    ]
    fair = compare(
        "Our control, no claim of the thesis: with the same known views the network is more accurate than SHOT",
        column(control, "accuracy", 100),
        accuracy["SHOT"],
        "points",
    )
    return [*map(str, claims), str(fair)]


def _rank(rows: Sequence[dict[str, Any]]) -> str:
    """The descriptors by seconds, here and in the thesis."""
    key = f"seconds_for_{TESTED}"
    seconds = {row["classifier"]: row[key] for row in rows if row["classifier"].lower() in THESIS}
    here = sorted(seconds, key=seconds.__getitem__)
    thesis = sorted(seconds, key=lambda name: THESIS[name.lower()][1])
    network = min(row[key] for row in rows)
    return (
        f"From fast to slow: {', '.join(here)}; in the thesis: {', '.join(thesis)}. The network takes {network:.2g} s, "
        f"{min(seconds.values()) / network:.0f} times less than the fastest descriptor."
    )


def _mean(runs: Sequence[dict[str, Any]], key: str, factor: float = 1.0) -> float:
    return float(np.mean(column(runs, key, factor)))


def _draw(runs: Runs, rows: Sequence[dict[str, Any]]) -> drawing.Figure:
    figure, ((accuracy, seconds),) = drawing.new_figure(1, 2, width=9, height=3.8)
    drawing.draw_boxes(
        accuracy,
        {name: column(found, "accuracy", 100) for name, found in runs.items()},
        "accuracy of the test views [%]",
        sideways=True,
    )
    known = [(i, row) for i, row in enumerate(rows) if row["thesis_accuracy_percent"] is not None]
    accuracy.plot([row["thesis_accuracy_percent"] for _, row in known], [i for i, _ in known], label="thesis", **_STAR)
    seconds.barh(range(len(rows)), [row[f"seconds_for_{TESTED}"] for row in rows], 0.6, color=drawing.COLORS[0])
    given = [
        (i, THESIS[row["classifier"].lower()][1]) for i, row in enumerate(rows) if row["classifier"].lower() in THESIS
    ]
    seconds.plot([value for _, value in given], [i for i, _ in given], **_STAR)
    seconds.set_xscale("log")
    seconds.set_xlabel(f"seconds for {TESTED} views")
    seconds.set_yticks(range(len(rows)), [])
    seconds.set_ylim(accuracy.get_ylim())
    seconds.grid(visible=False, axis="y")
    drawing.legend_below(figure, accuracy)
    return figure
