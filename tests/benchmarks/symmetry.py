"""Whether `ok` can be believed on objects that repeat themselves: `make bench-symmetry`, or `QUICK=--quick` of it.

Solids with turns that nothing tells apart, mugs that only their handle tells apart, and objects without any symmetry;
each without the camera's step and with it. Sessions are kept in a file as they finish; with `--resume FILE` those in it
are not run again, whatever code they were run with: begin another file after a change. The whole takes some two hours
on two cores.
"""

import argparse
import random
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from itertools import product
from pathlib import Path
from typing import Literal

from pydantic import ValidationError
from rich.console import Console
from rich.progress import track

from tests.benchmarks.sessions import ASYMMETRIC
from tests.benchmarks.solids import SOLIDS
from tests.benchmarks.symmetry_scores import MUG, SCORE, Case, Found, Score, run
from tests.benchmarks.symmetry_tables import report, write_json
from tests.benchmarks.workers import pool

STEPS = (10, 20, 30, 45, 60, 90)  # degrees between successive views, of a whole turn
NOISE = (0.5, 1.0, 2.0)  # of the depth at 1 m [mm]
MUGS, MUG_STEP = range(1, 9), 30

Runner = Callable[[Case], Score]


def whole() -> list[Case]:
    """The sessions of a whole run, at most 600, in an order drawn once: a run cut short is a spread as well.

    Solids and controls: every step, known and not, but for 10 degrees not known, each with one noise in its turn.
    Mugs: eight instances by both sensors, known and not.
    """
    chosen = product(enumerate((*SOLIDS, *ASYMMETRIC)), enumerate(STEPS), (False, True))
    cases = [
        Case(name, step, NOISE[(n + s + known) % len(NOISE)], known)
        for (n, name), (s, step), known in chosen
        if step > 10 or known
    ]
    sensors: tuple[Literal["gaussian", "kinect"], ...] = ("gaussian", "kinect")
    cases += [
        Case(MUG, MUG_STEP, known=known, instance=instance, sensor=sensor)
        for instance, sensor, known in product(MUGS, sensors, (False, True))
    ]
    random.Random(0).shuffle(cases)
    return cases


def slice_of_it() -> list[Case]:
    """What `--quick` runs: sessions of at most eight views, of every family and kind, known and not."""
    return [
        Case("prism03", 60), Case("prism05", 45, known=True), Case("prism06", 60), Case("prism06", 45, 0.5, known=True),
        Case("prism12", 60, 0.5), Case("prism24", 90, 2.0), Case("gear09", 45), Case("gear09", 60, known=True),
        Case("gear18", 60, 0.5), Case("flute08", 45, 2.0), Case("flute12", 60, known=True),
        Case("box", 60), Case("box", 45, known=True), Case("carton", 90), Case("carton", 60, known=True),
        Case("cube", 60), Case("plate", 45), Case(MUG, 45), Case(MUG, 45, known=True, instance=2, sensor="kinect"),
        Case("robot", 60), Case("statue", 45, known=True), Case("vacuum_cleaner", 45, 2.0),
    ]  # fmt: skip


def run_all(cases: Sequence[Case], kept: Path, workers: int = 1, runner: Runner = run) -> Found:
    """The scores of all cases, each put into a file as it comes; those that are there already are not run again."""
    known = read(kept)
    waiting = [case for case in cases if case not in known]
    broken = []
    cut = kept.exists() and not (kept.read_bytes() or b"\n").endswith(b"\n")
    with kept.open("a", encoding="utf-8") as file:
        file.write("\n" * cut)  # after a line that a killed run left unfinished
        progress = track(_each(waiting, workers, runner), "Registering", len(waiting), console=Console(file=sys.stderr))
        for case, score in progress:
            if isinstance(score, Score):
                known[case] = score
                file.write(SCORE.dump_json(score).decode() + "\n")
                file.flush()
            else:
                broken.append(f"{case}: {score}")
    return Found(tuple(known[case] for case in cases if case in known), tuple(broken))


def read(kept: Path) -> dict[Case, Score]:
    """The scores in a file; without one, none. A line that was cut is no score."""
    found = {}
    for line in kept.read_text(encoding="utf-8").splitlines() if kept.exists() else ():
        try:
            score = SCORE.validate_json(line)
        except ValidationError:
            continue
        found[score.case] = score
    return found


def _each(cases: Sequence[Case], workers: int, runner: Runner) -> Iterator[tuple[Case, Score | str]]:
    """Every case with its score, or with what broke it, as they finish."""
    if workers == 1:
        yield from ((case, _try(case, runner)) for case in cases)
        return
    with pool(workers) as executor:
        jobs = {executor.submit(_try, case, runner): case for case in cases}
        for job in as_completed(jobs):
            yield jobs[job], job.result()


def _try(case: Case, runner: Runner) -> Score | str:
    """A case's score, or what broke it: a benchmark of hours must not end at one session."""
    try:
        return runner(case)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} ({where.filename}:{where.lineno})"


def main() -> None:
    """Run what the command line chooses, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a spread of small sessions, under ten minutes")
    parser.add_argument("--workers", type=int, default=2, help="sessions at a time")
    parser.add_argument("--json", type=Path, help="where to write the tables and every session")
    parser.add_argument("--resume", type=Path, help="where finished sessions are kept; those in it are not run again")
    options = parser.parse_args()
    kept = options.resume
    if kept is None:
        kept = Path(tempfile.mkdtemp(prefix="symmetry-")) / "sessions.jsonl"
        print(f"A run that is cut short goes on with --resume {kept}", flush=True)
    found = run_all(slice_of_it() if options.quick else whole(), kept, options.workers)
    if options.json:
        write_json(found, options.quick, options.json)
    report(found, options.quick)


if __name__ == "__main__":
    main()
