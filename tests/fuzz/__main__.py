"""`make fuzz`: 500 damaged recordings, a table of what became of them, status 1 where something is wrong."""

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from recorder.progress import progress
from tests.fuzz.mutations import KINDS
from tests.fuzz.original import make_original
from tests.fuzz.trial import Trial, process_undamaged, run_trial


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--first", type=int, default=0, help="number of the first one; a number makes the same damage")
    parser.add_argument("--count", type=int, default=500)
    options = parser.parse_args()
    started = time.perf_counter()
    trials = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        original = make_original(folder)
        usual = process_undamaged(original, folder)
        numbers = range(options.first, options.first + options.count)
        for number in progress(numbers, options.count, "Damaging"):
            trial = run_trial(original, number, folder, usual)
            trials.append(trial)
            if trial.complaints:
                print(f"\n{trial.what}\n  again: python -m tests.fuzz --first {number} --count 1", file=sys.stderr)
                print(*trial.complaints, sep="\n", file=sys.stderr)
    report(trials)
    failed = sum(bool(trial.complaints) for trial in trials)
    print(f"{len(trials)} damaged recordings in {time.perf_counter() - started:.0f} s, {failed} failures")
    return 1 if failed else 0


def report(trials: list[Trial]) -> None:
    """A row for each kind of damage; a recording damaged in several ways counts by the first."""
    print(f"{'damage':<10} {'number':>6} {'whole':>6} {'part':>6} {'refused':>8} {'slowest [s]':>12}")
    for kind in KINDS:
        rows = [trial for trial in trials if trial.kinds[0] == kind]
        outcomes = Counter(trial.outcome for trial in rows)
        slowest = max((trial.seconds for trial in rows), default=0)
        counts = f"{outcomes['whole']:>6} {outcomes['part']:>6} {outcomes['refused']:>8}"
        print(f"{kind:<10} {len(rows):>6} {counts} {slowest:>12.2f}")
    whole, out = (sum(trial.views[i] for trial in trials) for i in (0, 1))
    print(f"views: {whole} whole in the files, {out} come out")


if __name__ == "__main__":
    sys.exit(main())
