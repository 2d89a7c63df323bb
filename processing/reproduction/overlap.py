"""Is the method "irrespective of the initial transformation if only a portion of overlap exists", as it claims?"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import binomtest

from processing.reproduction import drawing
from processing.reproduction.claims import CONFIDENCE, FEWEST_RUNS, Claim, compare
from processing.reproduction.overlap_runs import (
    GATE_SHARE,
    METHODS,
    MOST_DEG,
    MOST_SHARE,
    Pairs,
    collect,
    register_pairs,
)
from processing.reproduction.plan import Plan
from processing.reproduction.report import Report
from processing.reproduction.runs import keep

OBJECTS = ("bin", "statue", "helicopter", "robot", "vacuum_cleaner")  # thesis 5.2
AZIMUTHS_DEG = (10, 20, 30, 40, 60, 80, 100, 120, 150, 180)
STARTS_DEG = (0, 30, 60, 90, 180)
_COARSE_BELOW = 0.2  # of the plan's fraction: each third azimuth, and two starts
THESIS = "ransac_icp"
NEAR_DEG = 40  # azimuths up to it tell whether the start matters
SAME_POINTS = 10.0  # success that differs by less is the same
OFTEN = 0.9

Trial = dict[str, Any]


def vary_overlap(plan: Plan) -> Report:
    """Success of each method against the overlap of two views and the angle of the start."""
    coarse = plan.fraction < _COARSE_BELOW
    azimuths, starts = (AZIMUTHS_DEG[1::3], (0, 90)) if coarse else (AZIMUTHS_DEG, STARTS_DEG)
    tasks = [Pairs(what, azimuths, starts, seed) for seed in plan.seeds for what in OBJECTS]
    trials = collect(keep(plan, register_pairs, tasks, "Registering pairs"), tasks)
    rows = [
        _summarise(found)
        for method in METHODS
        for azimuth in azimuths
        for start in starts
        if (found := _of(trials, method=method, azimuth_deg=azimuth, start_deg=start))
    ]
    return Report(
        "study-overlap",
        "Success against overlap and starting angle",
        rows,
        [*map(str, map(_independence, METHODS, [trials] * len(METHODS))), *_reach(trials, azimuths), *_false(trials)],
        {"study-overlap": _draw(trials, azimuths, starts)},
        {"wrong_beyond_deg": MOST_DEG, "wrong_beyond_diameters": MOST_SHARE, "overlap_gate_diameters": GATE_SHARE},
    )


def _of(trials: Sequence[Trial], **values: Any) -> list[Trial]:
    return [trial for trial in trials if all(trial[key] == value for key, value in values.items())]


def _share(trials: Sequence[Trial]) -> float:
    return float(np.mean([trial["success"] for trial in trials]))


def _summarise(trials: Sequence[Trial]) -> dict[str, Any]:
    """How often trials that are alike succeed, with Wilson's interval."""
    successes = sum(trial["success"] for trial in trials)
    interval = binomtest(successes, len(trials)).proportion_ci(CONFIDENCE, method="wilson")
    first = trials[0]
    return {
        "method": first["method"],
        "azimuth_deg": first["azimuth_deg"],
        "start_deg": first["start_deg"],
        "overlap_percent": 100 * float(np.mean([trial["overlap"] for trial in trials])),
        "trials": len(trials),
        "success_percent": 100 * successes / len(trials),
        "low_percent": 100 * interval.low,
        "high_percent": 100 * interval.high,
        "ok_but_wrong": sum(trial["ok_but_wrong"] for trial in trials),
    }


def _independence(method: str, trials: Sequence[Trial]) -> Claim:
    """Whether turned starts succeed as often as unturned ones where views are near, by objects and runs."""
    near = [trial for trial in _of(trials, method=method) if trial["azimuth_deg"] <= NEAR_DEG]
    units = sorted({(trial["object"], trial["run"]) for trial in near})
    unturned, turned = (
        [
            100 * _share([t for t in near if (t["object"], t["run"]) == unit and (t["start_deg"] > 0) == big])
            for unit in units
        ]
        for big in (False, True)
    )
    text = f"{method} succeeds as often from a turned start, views up to {NEAR_DEG} degrees apart"
    claim = compare(text, unturned, turned, "points from the unturned")
    if len(units) < FEWEST_RUNS:
        return claim
    same = max(abs(claim.low), abs(claim.high)) <= SAME_POINTS
    differs = claim.low > 0 or claim.high < 0
    return replace(claim, verdict="holds" if same else "does not hold" if differs else "cannot be told")


def _reach(trials: Sequence[Trial], azimuths: Sequence[int]) -> list[str]:
    """Down to which overlap each method succeeds often, all nearer views included."""
    said = []
    for method in METHODS:
        reached = None
        for azimuth in azimuths:
            found = _of(trials, method=method, azimuth_deg=azimuth)
            if _share(found) < OFTEN:
                break
            reached = azimuth, 100 * float(np.mean([trial["overlap"] for trial in found]))
        said.append(
            f"{method} succeeds in {100 * OFTEN:.0f} % of the trials "
            + (
                "at no distance"
                if reached is None
                else f"up to {reached[0]} degrees apart ({reached[1]:.0f} % overlap)"
            )
        )
    return ["; ".join(said) + "."]


def _false(trials: Sequence[Trial]) -> list[str]:
    """How often a pose that is called ok is wrong."""
    said = []
    for method in METHODS:
        found = [trial for trial in _of(trials, method=method) if trial["status"] == "ok"]
        said.append(f"{method} {sum(trial['ok_but_wrong'] for trial in found)} of {len(found)}")
    return [f"Poses called ok that are wrong: {', '.join(said)}."]


def _draw(trials: Sequence[Trial], azimuths: Sequence[int], starts: Sequence[int]) -> drawing.Figure:
    """Success against the overlap, against the start, and the thesis's method against both."""
    figure, (row,) = drawing.new_figure(1, 3, width=12, height=3.8)
    overlaps = [100 * np.mean([t["overlap"] for t in _of(trials, azimuth_deg=azimuth)]) for azimuth in azimuths]
    _draw_lines(row[0], overlaps, lambda method, i: _of(trials, method=method, azimuth_deg=azimuths[i]))
    row[0].set_xlabel("mean overlap of the views [%]")
    near = [trial for trial in trials if trial["azimuth_deg"] <= NEAR_DEG]
    _draw_lines(row[1], starts, lambda method, i: _of(near, method=method, start_deg=starts[i]))
    row[1].set_xlabel(f"turn of the start [degrees], views up to {NEAR_DEG} apart")
    thesis = _of(trials, method=THESIS)
    shares = np.array([[_share(_of(thesis, azimuth_deg=a, start_deg=s)) for a in azimuths] for s in starts])
    row[2].imshow(100 * shares, cmap="Greys", vmin=0, vmax=100, aspect="auto")
    for (i, j), share in np.ndenumerate(shares):
        color = "white" if share > 0.5 else "black"
        row[2].text(j, i, f"{100 * share:.0f}", ha="center", va="center", color=color, fontsize=8)
    row[2].set_xticks(range(len(azimuths)), azimuths)
    row[2].set_yticks(range(len(starts)), starts)
    row[2].set(xlabel="views apart [degrees]", ylabel="turn of the start [degrees]")
    row[2].set_title(f"{THESIS}: success [%]", fontsize=9)
    row[2].grid(visible=False)
    drawing.legend_below(figure, row[0])
    return figure


def _draw_lines(axes: drawing.Axes, x: Sequence[float], choose: Callable[[str, int], list[Trial]]) -> None:
    for i, method in enumerate(METHODS):
        shares = [100 * _share(choose(method, j)) for j in range(len(x))]
        style = {"linestyle": drawing.LINES[i], "color": drawing.COLORS[i], "marker": drawing.MARKERS[i]}
        axes.plot(x, shares, label=method, markersize=4, **style)
    axes.set_ylabel("success [%]")
    axes.set_ylim(-3, 103)
