"""`make fuzz`: 500 damaged recordings, a table of what became of them, status 1 where something is wrong."""

import argparse
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from orbitscan.processing.batch.compilation import ensure_compiled
from orbitscan.recorder.console import progress
from tests.fuzz.mutations import KINDS
from tests.fuzz.trial import Trial, run_trials

AT_ONCE = 25  # recordings a process takes before another one goes on: reviews leave memory behind


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--first", type=int, default=0, help="number of the first one; a number makes the same damage")
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--workers", type=int, default=min(4, os.cpu_count() or 1))
    options = parser.parse_args()
    ensure_compiled()
    started = time.perf_counter()
    end = options.first + options.count
    parts = [range(first, min(first + AT_ONCE, end)) for first in range(options.first, end, AT_ONCE)]
    os.environ["OMP_NUM_THREADS"] = os.environ["NUMBA_NUM_THREADS"] = "1"  # of each worker
    trials = []
    with ProcessPoolExecutor(options.workers, mp_context=get_context("spawn"), max_tasks_per_child=1) as pool:
        for part in progress(pool.map(run_trials, parts), len(parts), "Damaging"):
            trials += part
            for trial in part:
                if trial.complaints:
                    print(f"\n{trial.what}\n  again: make fuzz FIRST={trial.number} COUNT=1", file=sys.stderr)
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
    unreachable = sum(trial.views[0] for trial in trials if trial.outcome == "refused")
    print(f"views: {whole} whole in the files, {out} come out; {unreachable} in files without start and end")
    print(f"memory: {max((trial.peak_mb for trial in trials), default=0):.0f} MB at most")


if __name__ == "__main__":
    sys.exit(main())
