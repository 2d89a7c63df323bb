"""Table 5.3: the network from four initialisations against four descriptors, by accuracy and by seconds."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from orbitscan.processing.classification.descriptor_matching import Kind
from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import Claim, compare
from orbitscan.processing.reproduction.descriptors.run import KNOWN, TESTED, Learning, Matching, choose, run_once
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, Row
from orbitscan.processing.reproduction.runs import keep
from orbitscan.processing.reproduction.training import data, initializations
from orbitscan.processing.reproduction.training.initializations import NAMES, draw_score_boxes
from orbitscan.processing.reproduction.training.run import Runs, average, change_thesis, column

THESIS: dict[Kind, tuple[float, int]] = {  # accuracy [%], seconds for TESTED views
    "shot": (91.77, 175),
    "fpfh": (87.55, 240),
    "pfh": (89.87, 6049),
    "esf": (83.54, 15),
}
_BY_NAME = {kind.upper(): numbers for kind, numbers in THESIS.items()}  # as the rows name the descriptors
THESIS_NETWORK_S = 0.1  # at most, on a GPU
SAME = "Glorot, same test views"  # the network on what the descriptors name
CONTROL = f"Glorot, {KNOWN} views each"  # and on what they know
SECONDS = f"seconds_for_{TESTED}"
Results = Sequence[dict[str, Any]]  # of several runs
_STAR = {"linestyle": "", "marker": "*", "markersize": 10, "color": "black", "markeredgecolor": "white"}


def compare_descriptors(plan: Plan) -> Report:
    """Table 5.3: accuracy and seconds of the network and of each descriptor."""
    networks = {NAMES[init]: runs for init, runs in initializations.run_all(plan).items()}
    matched = _match_all(plan)
    rows = _tabulate(networks, matched)
    return Report(
        "table-5.3",
        "Networks against descriptors",
        rows,
        said=[_describe(matched), _rank(matched)],
        claims=_claim(networks, matched),
        figures={"table-5.3": _draw(networks | matched, rows)},
        settings={"known_views_of_a_category": KNOWN, "tested_views": matched[SAME][0]["tested"], "threads": 1},
        shown=[name for name in rows[0] if not name.endswith(("_measured", "_gpu"))],
    )


def _match_all(plan: Plan) -> Runs:
    """The runs of each descriptor, and of the network on the same views: all that name exactly the same ones."""
    found = data.provide(plan)
    every = 1 if plan.dataset is None else plan.every  # a virtual circle is recorded thinned
    sessions = data.open_circles(plan)
    how = change_thesis({"precision": plan.precision})
    slowest: list[Kind] = sorted(THESIS, key=lambda kind: -THESIS[kind][1])  # first, so that no worker waits for it
    tasks: list[Matching | Learning] = []
    for seed in plan.seeds:
        choice = choose(sessions, every, seed)
        tasks += [Matching(kind, found, *choice, seed) for kind in slowest]
        tasks += [Learning(learns, found, *choice, how, seed, plan.device) for learns in ("all", "known")]
    results = keep(plan, run_once, tasks, "Matching descriptors, and networks on the same views")
    names = [*(kind.upper() for kind in slowest), SAME, CONTROL]
    runs = {name: results[i :: len(names)] for i, name in enumerate(names)}
    return {name: runs[name] for name in (*_BY_NAME, SAME, CONTROL)}


def _tabulate(networks: Runs, matched: Runs) -> list[Row]:
    """A row for each classifier: the means over the runs; networks of one structure take one time."""
    network = f"< {THESIS_NETWORK_S} (GPU)"
    rows = [
        _row(name, runs, matched[SAME], "all", initializations.THESIS[init][0], network)
        for (name, runs), init in zip(networks.items(), NAMES, strict=True)
    ]
    for name, runs in matched.items():
        accuracy, seconds = _BY_NAME.get(name, (None, None))
        written = None if seconds is None else str(seconds)
        rows.append(_row(name, runs, runs, str(runs[0]["tested"]), accuracy, written))
    return rows


def _row(name: str, runs: Results, timed: Results, tested: str, accuracy: float | None, seconds: str | None) -> Row:
    """The row of a classifier; accuracy and seconds are the thesis's."""
    return {
        "classifier": name,
        "known_views": timed[0]["known"],
        "tested_views": tested,
        "accuracy_percent": average(runs, "accuracy", 100),
        "thesis_accuracy_percent": accuracy,
        SECONDS: float(np.mean(_scale(timed))),
        f"{SECONDS}_gpu": _scale_gpu(timed),
        "thesis_seconds": seconds,
        "seconds_measured": average(timed, "seconds"),
        "views_measured": timed[0]["tested"],
    }


def _describe(matched: Runs) -> str:
    """Which views each classifier knew and named, in words."""
    network, tested = matched[SAME][0], matched[SAME][0]["tested"]
    few = matched["SHOT"][0]["known"]
    scaled = "" if tested == TESTED else f"; the seconds are scaled to {TESTED}"
    return (
        f"The descriptors know {few} views, {KNOWN} of each category at most, drawn anew for each run, and name "
        f"{tested} of the test views, on one thread{scaled}. The networks have {network['known']} training views, "
        f"{network['known'] / few:.1f} times as many, and their accuracy is of all test views; in the thesis, too, the "
        f"descriptors had a part of the views only. The last two rows name the same views as the descriptors: "
        f"'{SAME}' has all training views, '{CONTROL}' those the descriptors know, in as many batches."
    )


def _claim(networks: Runs, matched: Runs) -> list[Claim]:
    """The thesis's orders by accuracy and by seconds, each step a claim, and our controls."""
    accuracy = {name: column(runs, "accuracy", 100) for name, runs in (networks | matched).items()}
    seconds = {name: _scale(runs) for name, runs in matched.items()}
    order, slowest = (sorted(_BY_NAME, key=lambda name: -_BY_NAME[name][i]) for i in (0, 1))
    ours = "Our control, no claim of the thesis: "
    accurate = [(f"The network from {name} is more accurate than SHOT", name, "SHOT") for name in networks]
    accurate += [(f"{better} is more accurate than {worse}", better, worse) for better, worse in pairwise(order)]
    accurate += [
        (f"{ours}on the same test views the network is more accurate than SHOT", SAME, "SHOT"),
        (f"{ours}with the same known views the network is more accurate than SHOT", CONTROL, "SHOT"),
    ]
    slow = [(f"{slower} takes longer than {faster}", slower, faster) for slower, faster in pairwise(slowest)]
    slow.append((f"{slowest[-1]} takes longer than the network", slowest[-1], SAME))
    return [
        *(compare(text, accuracy[a], accuracy[b], "points") for text, a, b in accurate),
        *(compare(text, seconds[a], seconds[b], "s") for text, a, b in slow),
    ]


def _rank(matched: Runs) -> str:
    """The descriptors by seconds, here and in the thesis."""
    seconds = {name: float(np.mean(_scale(matched[name]))) for name in (*_BY_NAME, SAME)}
    here = sorted(_BY_NAME, key=seconds.__getitem__)
    thesis = sorted(_BY_NAME, key=lambda name: _BY_NAME[name][1])
    gpu = _scale_gpu(matched[SAME])
    return (
        f"From fast to slow: {', '.join(here)}; in the thesis: {', '.join(thesis)}. For {TESTED} views {here[0]} takes "
        f"{seconds[here[0]]:.3g} s, the network {seconds[SAME]:.2g} s on one thread"
        + (f" and {gpu:.2g} s on the GPU." if gpu else ".")
    )


def _scale(runs: Results, key: str = "seconds") -> list[float]:
    """The seconds of every run for as many views as the thesis's."""
    return [run[key] * TESTED / run["tested"] for run in runs]


def _scale_gpu(runs: Results) -> float | None:
    """The mean seconds on the GPU for as many views as the thesis's; None where nothing ran on one."""
    return None if runs[0].get("gpu_seconds") is None else float(np.mean(_scale(runs, "gpu_seconds")))


def _draw(runs: Runs, rows: Sequence[Row]) -> charts.Figure:
    figure, ((accuracy, seconds),) = charts.new_figure(1, 2, width=9, height=4)
    draw_score_boxes(accuracy, runs, "accuracy", sideways=True)
    known = [(i, row) for i, row in enumerate(rows) if row["thesis_accuracy_percent"] is not None]
    accuracy.plot([row["thesis_accuracy_percent"] for _, row in known], [i for i, _ in known], label="thesis", **_STAR)
    dots, blue = {"linestyle": "", "markersize": 6}, charts.COLORS[0]
    seconds.plot([row[SECONDS] for row in rows], range(len(rows)), "o", color=blue, label="one thread", **dots)
    gpu = [(i, row[f"{SECONDS}_gpu"]) for i, row in enumerate(rows) if row[f"{SECONDS}_gpu"]]
    if gpu:
        style = {"markerfacecolor": "white", "color": blue} | dots
        seconds.plot([value for _, value in gpu], [i for i, _ in gpu], "s", label="GPU", **style)
    given = [(i, _BY_NAME[name][1]) for i, name in enumerate(runs) if name in _BY_NAME]
    seconds.plot([value for _, value in given], [i for i, _ in given], **_STAR)
    below = [i for i, row in enumerate(rows) if str(row["thesis_seconds"]).startswith("<")]
    fast = [THESIS_NETWORK_S] * len(below)
    seconds.plot(fast, below, "<", color="black", label="thesis, less than that (GPU)", **dots)
    seconds.set_xscale("log")
    seconds.set_xlabel(f"seconds for {TESTED} views [s]")
    seconds.set_yticks(range(len(rows)), [])
    seconds.set_ylim(accuracy.get_ylim())
    seconds.grid(visible=False, axis="y")
    figure.legend(loc="outside lower center", ncols=4, frameon=False)
    return figure
