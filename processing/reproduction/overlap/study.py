"""Is the method "irrespective of the initial transformation if only a portion of overlap exists", as it claims?"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from orbitscan.processing.reproduction.claims import Claim, Verdict, compare
from orbitscan.processing.reproduction.overlap.drawing import draw_success
from orbitscan.processing.reproduction.overlap.run import GATE_SHARE, METHODS, Pairs, register_pairs
from orbitscan.processing.reproduction.overlap.trials import (
    MOST_DEG,
    MOST_SHARE,
    OVERLAPS,
    Trial,
    choose,
    collect,
    interval,
    mean,
    within,
)
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.registration.run import OBJECTS
from orbitscan.processing.reproduction.report import Report
from orbitscan.processing.reproduction.runs import keep

AZIMUTHS_DEG = (10, 20, 30, 40, 60, 80, 100, 120, 150, 180)
STARTS_DEG = (0, 30, 60, 90, 180)
_COARSE_BELOW = 0.2  # of the plan's fraction: each third azimuth, and two starts
THESIS = "ransac_icp"
NEAR_DEG = 40  # azimuths up to it tell whether the start matters
SAME_POINTS = 10.0  # success that differs by less is the same ...
WORKS = 0.5  # ... where a method succeeds as often as this from one of them: what always fails depends on nothing
OFTEN = 0.9


def vary_overlap(plan: Plan) -> Report:
    """How often each method succeeds, by the overlap of two views and the angle of the start."""
    coarse = plan.fraction < _COARSE_BELOW
    azimuths, starts = (AZIMUTHS_DEG[1::3], (0, 90)) if coarse else (AZIMUTHS_DEG, STARTS_DEG)
    tasks = [Pairs(what, azimuth, starts, seed) for seed in plan.seeds for what in OBJECTS for azimuth in azimuths]
    trials = collect(keep(plan, register_pairs, tasks, "Registering pairs"), tasks)
    return Report(
        "study-overlap",
        "Success against overlap and starting angle",
        list(_tabulate(trials, azimuths, starts)),
        said=[*(_describe_reach(method, trials) for method in METHODS), _compare_objects(trials), _count_wrong(trials)],
        claims=[_claim_independence(method, trials) for method in METHODS],
        figures={"study-overlap": draw_success(trials, _near(trials), choose(trials, method=THESIS), azimuths, starts)},
        settings={
            "wrong_beyond_deg": MOST_DEG,
            "wrong_beyond_diameters": MOST_SHARE,
            "overlap_gate_diameters": GATE_SHARE,
            "intervals": "Wilson's, trials taken for independent",
        },
    )


def _tabulate(trials: Sequence[Trial], azimuths: Sequence[int], starts: Sequence[int]) -> Iterator[dict[str, Any]]:
    """Rows by overlap and start, by azimuth and start, and by object and azimuth over all starts; None: any."""
    for method in METHODS:
        own = choose(trials, method=method)
        for low, high in OVERLAPS:
            inside = within(own, low, high)
            for start in starts:
                yield from _summarise(choose(inside, start_deg=start), overlap=f"{low} to {high}", start=start)
    for method in METHODS:
        own = choose(trials, method=method)
        for azimuth in azimuths:
            for start in starts:
                yield from _summarise(choose(own, azimuth_deg=azimuth, start_deg=start), azimuth=azimuth, start=start)
    for method in METHODS:
        for what in OBJECTS:
            for azimuth in azimuths:
                found = choose(trials, method=method, object=what, azimuth_deg=azimuth)
                yield from _summarise(found, what=what, azimuth=azimuth)


def _summarise(
    trials: Sequence[Trial],
    what: str = "all",
    overlap: str | None = None,
    azimuth: int | None = None,
    start: int | None = None,
) -> Iterator[dict[str, Any]]:
    """How often trials that are alike succeed, with Wilson's interval; no row where there are none."""
    if not trials:
        return
    successes = sum(trial["success"] for trial in trials)
    low, high = interval(trials)
    yield {
        "method": trials[0]["method"],
        "object": what,
        "overlap_from_to_percent": overlap,
        "azimuth_deg": azimuth,
        "start_deg": start,
        "mean_overlap_percent": 100 * mean(trials, "overlap"),
        "mean_start_error_deg": mean(trials, "start_error_deg"),
        "trials": len(trials),
        "successes": successes,
        "success_percent": 100 * successes / len(trials),
        "low_percent": low,
        "high_percent": high,
        "ok_but_wrong": sum(trial["ok_but_wrong"] for trial in trials),
    }


def _near(trials: Sequence[Trial]) -> list[Trial]:
    return [trial for trial in trials if trial["azimuth_deg"] <= NEAR_DEG]


def _claim_independence(method: str, trials: Sequence[Trial]) -> Claim:
    """The claim that turned starts succeed as often as unturned ones, run by run, on the same pairs of near views.

    It holds where the interval of the difference stays within SAME_POINTS and the method works at all.
    """
    near = _near(choose(trials, method=method))
    runs = sorted({trial["run"] for trial in near})
    unturned, turned = (
        [100 * mean([t for t in near if t["run"] == run and (t["start_deg"] > 0) == big], "success") for run in runs]
        for big in (False, True)
    )
    text = (
        f"{method} succeeds as often from a turned start ({np.mean(turned):.0f} % of the trials) as from an unturned "
        f"one ({np.mean(unturned):.0f} %), views up to {NEAR_DEG} degrees apart"
    )
    claim = compare(text, unturned, turned, "points from the unturned")
    if claim.interval is None:
        return claim
    low, high = claim.interval
    works = max(np.mean(unturned), np.mean(turned)) >= 100 * WORKS
    same = works and max(abs(low), abs(high)) <= SAME_POINTS
    differs = low > 0 or high < 0
    return replace(claim, verdict=Verdict.HOLDS if same else Verdict.FAILS if differs else Verdict.OPEN)


def _describe_reach(method: str, trials: Sequence[Trial]) -> str:
    """Down to which overlap a method succeeds often, and at least half of the time, in words."""
    own = choose(trials, method=method)
    often, half = (_least_overlap(own, share) for share in (OFTEN, WORKS))
    return f"{method} succeeds in {100 * OFTEN:.0f} % of the trials {often}, in {100 * WORKS:.0f} % {half}."


def _least_overlap(trials: Sequence[Trial], share: float) -> str:
    least = None
    for low, high in reversed(OVERLAPS):
        found = within(trials, low, high)
        if found and mean(found, "success") < share:
            break
        least = low if found else least
    return "nowhere" if least is None else f"down to {least} % overlap"


def _compare_objects(trials: Sequence[Trial]) -> str:
    """Down to which overlap the thesis's method succeeds half of the time, by object, in words."""
    said = [
        f"{what.replace('_', ' ')} {_least_overlap(choose(trials, method=THESIS, object=what), WORKS)}"
        for what in OBJECTS
    ]
    return f"{THESIS} succeeds in {100 * WORKS:.0f} % of the trials, by object: {', '.join(said)}."


def _count_wrong(trials: Sequence[Trial]) -> str:
    """How often a pose that is called ok is wrong, in words."""
    found = {method: choose(trials, method=method, status="ok") for method in METHODS}
    said = [f"{m} {sum(trial['ok_but_wrong'] for trial in ok)} of {len(ok)}" for m, ok in found.items()]
    return f"Poses called ok that are wrong: {', '.join(said)}."
