"""Whether the bounds of poses can be believed: `python -m tests.benchmarks.calibration`.

Objects of the thesis and others, by a camera with noise and by a Kinect; the truth must lie within the stated 95 %
bound for 90 to 99 % of what is called ok. Sessions are kept in a file as they finish, as those of `bench-symmetry` are,
in an order drawn once: a run cut short is a spread as well. The whole takes an hour on two cores.
"""

import argparse
import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from orbitscan.processing.results.status import Status
from tests.benchmarks.symmetry import run_all
from tests.benchmarks.symmetry_scores import RUN, Case, Found, PairScore, Score, ViewScore
from tests.benchmarks.symmetry_tables import is_off, show_interval
from tests.benchmarks.tables import print_table

CATEGORIES = (
    "apple", "bell_pepper", "bowl", "cap", "cell_phone",
    "coffee_mug", "dry_battery", "notebook", "pliers", "water_bottle",
)  # fmt: skip
OTHERS = ("robot", "statue", "bin", "helicopter", "vacuum_cleaner")
INSTANCES, STEPS, NOISE = (1, 4, 7), (20, 30), (0.5, 1.0, 2.0)


class Known(NamedTuple):
    """An ok view or pair: what it is off, and what it says it may be off; degrees, millimetres."""

    degrees: float
    bound_deg: float
    mm: float
    bound_mm: float
    wrong: bool


def whole() -> list[Case]:
    """The sessions of a whole run: each object at each step by a Kinect, and with one noise, each in its turn."""
    objects = [*product(CATEGORIES, INSTANCES), *product(OTHERS, (1,))]
    turned = enumerate(product(objects, STEPS))
    cases = [Case(name, step, NOISE[k % len(NOISE)], instance=number) for k, ((name, number), step) in turned]
    cases += [replace(case, noise=1.0, sensor="kinect") for case in cases]
    random.Random(0).shuffle(cases)
    return cases


def collect(scores: Sequence[Score], method: str) -> list[Known]:
    """What is ok in sessions: pairs of `pairwise`, and views of `refined`."""
    found: list[Known] = []
    for score in scores:
        of = score.methods[method]
        entries: Sequence[ViewScore | PairScore] = of.pairs if method == "pairwise" else of.views
        for entry in entries:
            if entry.status == Status.OK and None not in (entry.degrees, entry.metres):
                off = entry.degrees, entry.bound_deg or 0.0, 1e3 * entry.metres, 1e3 * (entry.bound_m or 0.0)
                found.append(Known(*off, is_off(entry, score.diameter)))
    return found


def report(found: Found) -> None:
    """Print a table of pairs and one of views, by object and by sensor, and what broke."""
    for method, what in zip(RUN, ("ok pairs of pairwise", "ok views of refined"), strict=True):
        print(f"\n{what}\n")
        rows = [row for name, scores in _groups(found.scores) if (row := _row(name, collect(scores, method)))]
        head = "", "ok", "within deg", "within mm", "bound / error, median", "mm", "error deg, median", "wrong (95 %)"
        print_table(head, rows)
    print("\n".join(["", *(f"broken: {line}" for line in found.broken)]))


def _groups(scores: Sequence[Score]) -> list[tuple[str, list[Score]]]:
    keys: list[tuple[str, Callable[[Case], bool]]] = [
        (name, lambda case, name=name: case.object == name) for name in (*CATEGORIES, *OTHERS)
    ]
    keys += [
        (f"gaussian {noise:g} mm", lambda case, noise=noise: case.sensor == "gaussian" and case.noise == noise)
        for noise in NOISE
    ]
    keys += [("kinect", lambda case: case.sensor == "kinect"), ("all", lambda case: True)]
    return [(name, [score for score in scores if belongs(score.case)]) for name, belongs in keys]


def _row(name: str, known: Sequence[Known]) -> list[object]:
    if not known:
        return []
    degrees, bounds, mm, bounds_mm, wrong = (np.array(column) for column in zip(*known, strict=True))
    return [
        name, len(known), f"{100 * np.mean(degrees <= bounds):.0f} %", f"{100 * np.mean(mm <= bounds_mm):.0f} %",
        f"{np.median(bounds / np.maximum(degrees, 1e-9)):.2f}", f"{np.median(bounds_mm / np.maximum(mm, 1e-9)):.2f}",
        f"{np.median(degrees):.3f}", show_interval(int(wrong.sum()), len(known)),
    ]  # fmt: skip


def main() -> None:
    """Run what the command line chooses, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--workers", type=int, default=2, help="sessions at a time")
    parser.add_argument("--first", type=int, help="only so many sessions")
    parser.add_argument("--resume", type=Path, help="where finished sessions are kept; those in it are not run again")
    options = parser.parse_args()
    kept = options.resume or Path(tempfile.mkdtemp(prefix="calibration-")) / "sessions.jsonl"
    print(f"A run that is cut short goes on with --resume {kept}", flush=True)
    report(run_all(whole()[: options.first], kept, options.workers))


if __name__ == "__main__":
    main()
