"""Whether colours decide what shapes leave open, and nothing else: `make bench-color`, or `QUICK=--quick` of it.

Objects that repeat themselves or slide, with a print all round, with one label or stripe, and plain before a lamp that
shines on them; plain ones with colours left out besides, which must come out the same. Sessions are kept in a file as
they finish, in an order drawn once, as those of `bench-symmetry` are. The whole takes some three hours on two cores.
"""

import argparse
import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from orbitscan.processing.registration.color.decision import COLOR
from orbitscan.processing.results.status import Status
from orbitscan.recorder.simulation.appearance import LAMPS, Lamp, Paint
from tests.benchmarks.solids import SOLIDS
from tests.benchmarks.symmetry import run_all
from tests.benchmarks.symmetry_scores import Case, Found, Score
from tests.benchmarks.symmetry_tables import is_off, show_interval, wrong
from tests.benchmarks.tables import print_table

STEP, GLOSS = 30, 0.5
MUGS, PHONES = tuple(("coffee_mug", n) for n in range(1, 9)), tuple(("cell_phone", n) for n in (1, 4, 7))
REVOLVED = tuple((name, 1) for name in ("water_bottle", "bowl", "apple", "dry_battery"))
FAMILIES = {"solids": tuple((name, 1) for name in SOLIDS), "mugs": MUGS, "phones": PHONES, "revolved": REVOLVED}
FEW = (
    ("prism06", 1), ("carton", 1), ("box", 1), ("gear12", 1), ("flute12", 1),
    ("coffee_mug", 1), ("cell_phone", 1), ("water_bottle", 1), ("bowl", 1), ("dry_battery", 1),
)  # fmt: skip
SENSORS: tuple[Literal["gaussian", "kinect"], ...] = ("gaussian", "kinect")


def whole() -> list[Case]:
    """The sessions of a whole run: prints in every light, labels in one, plain bodies in two; sensors in their turn."""
    everything = [thing for family in FAMILIES.values() for thing in family]
    cases = [
        _case(name, number, "print", lamp, k + m)
        for k, (name, number) in enumerate(everything)
        for m, lamp in enumerate(LAMPS)
    ]
    marks = [
        _case(name, number, paint, LAMPS[k % 3], k + m)
        for k, (name, number) in enumerate(FEW)
        for m, paint in enumerate(("label", "stripe"))
    ]
    plain = [
        _case(name, number, "plain", lamp, k + m)
        for k, (name, number) in enumerate(FEW)
        for m, lamp in enumerate(("camera", "room"))
    ]
    cases += marks + plain + [replace(case, color=False) for case in plain]
    random.Random(0).shuffle(cases)
    return cases


def slice_of_it() -> list[Case]:
    """What `--quick` runs: a few sessions of at most eight views."""
    few = [
        _case("prism06", 1, "print", "camera", 0), _case("carton", 1, "print", "room", 1),
        _case("water_bottle", 1, "print", "object", 0), _case("prism06", 1, "label", "camera", 0),
        _case("water_bottle", 1, "plain", "room", 0), _case("bowl", 1, "plain", "camera", 1),
    ]  # fmt: skip
    return [replace(case, step=45) for case in (*few, *(replace(case, color=False) for case in few[-2:]))]


def _case(name: str, number: int, paint: Paint, lamp: Lamp, turn: int) -> Case:
    return Case(name, STEP, instance=number, sensor=SENSORS[turn % 2], paint=paint, lamp=lamp, gloss=GLOSS)


def report(found: Found) -> None:
    """Print what became of the views of `refined`, by paint, family, lamp and sensor; what is wrong, and what broke."""
    rows = [row for name, belongs in _groups() if (row := _row(name, [s for s in found.scores if belongs(s.case)]))]
    head = "", "sessions", "views", "ok and right", "wrong (95 %)", "pairs by colour", "error deg, median", "seconds"
    print_table(head, rows)
    if changed := list_changed(found.scores):
        print("\nplain, but not as without colours:", *changed, sep="\n")
    for score in found.scores:
        if views := wrong(score, "refined"):
            print(f"wrong: {score.case}: {', '.join(f'{view.view} by {view.degrees:.1f} deg' for view in views)}")
    print("\n".join(["", *(f"broken: {line}" for line in found.broken)]))


def list_changed(scores: Sequence[Score]) -> list[str]:
    """The plain sessions in which a view has another status than with colours left out."""
    statuses = {score.case: [view.status for view in score.methods["refined"].views] for score in scores}
    plain = [case for case in statuses if case.paint == "plain" and case.color]
    return [str(case) for case in plain if statuses.get(replace(case, color=False), statuses[case]) != statuses[case]]


def _groups() -> list[tuple[str, Callable[[Case], bool]]]:
    groups: list[tuple[str, Callable[[Case], bool]]] = [
        (f"print, {name}", lambda case, of=of: case.paint == "print" and (case.object, case.instance) in of)
        for name, of in FAMILIES.items()
    ]
    groups += [
        (f"print, lamp {lamp}, {sensor}", lambda c, of=("print", lamp, sensor): (c.paint, c.lamp, c.sensor) == of)
        for lamp in LAMPS
        for sensor in SENSORS
    ]
    groups += [(paint, lambda case, of=paint: case.paint == of) for paint in ("print", "label", "stripe")]
    groups.append(("plain", lambda case: case.paint == "plain" and case.color))
    groups.append(("plain, colours left out", lambda case: not case.color))
    return groups


def _row(name: str, scores: Sequence[Score]) -> list[object]:
    if not scores:
        return []
    views = [(view, score) for score in scores for view in score.methods["refined"].views]
    ok = [(view, score) for view, score in views if view.status == Status.OK]
    right = [view for view, score in ok if not is_off(view, score.diameter)]
    pairs = [pair for score in scores for pair in score.methods["refined"].pairs if pair.status == Status.OK]
    degrees = [view.degrees for view in right if view.degrees is not None]
    return [
        name, len(scores), len(views), f"{len(right)} = {100 * len(right) / len(views):.0f} %",
        show_interval(len(ok) - len(right), len(ok)) if ok else "-",
        sum(pair.start == COLOR for pair in pairs), f"{np.median(degrees):.3f}" if degrees else "-",
        f"{sum(score.seconds for score in scores):.0f}",
    ]  # fmt: skip


def main() -> None:
    """Run what the command line chooses, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a few small sessions, some five minutes")
    parser.add_argument("--workers", type=int, default=2, help="sessions at a time")
    parser.add_argument("--resume", type=Path, help="where finished sessions are kept; those in it are not run again")
    options = parser.parse_args()
    kept = options.resume or Path(tempfile.mkdtemp(prefix="color-")) / "sessions.jsonl"
    print(f"A run that is cut short goes on with --resume {kept}", flush=True)
    report(run_all(slice_of_it() if options.quick else whole(), kept, options.workers))


if __name__ == "__main__":
    main()
