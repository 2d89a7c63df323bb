"""The whole benchmark in one run, `make bench`: accuracy, speed, memory, and what they must show; `--quick`: a slice.

Accuracy uses two processes; speed and memory are measured after it, alone. The whole takes an hour or two.
"""

import argparse
import subprocess
import sys
import time
from itertools import product
from pathlib import Path

from orbitscan.processing.results.status import METHODS
from tests.benchmarks import sessions, speed, targets
from tests.benchmarks.registration import CONTROL, Job, choose, report, run_all, write_json
from tests.benchmarks.sessions import Case


def whole(seeds: range) -> list[Case]:
    """Every object, step and noise; unknown starts; other paths, sizes and numbers of points; the anchor."""
    objects, steps = sessions.available(), (20, 40, 60)
    cases = [Case(*chosen) for chosen in product(objects, steps, (0.0, 0.5, 1.0, 2.0), seeds)]
    cases += [Case(o, step, seed=s, random_frames=True) for o, step, s in product(objects, steps, seeds)]
    cases += [Case(o, 20, seed=s, path=path) for o, path, s in product(objects, ("uneven", "random"), seeds)]
    cases += [Case(o, step, size=size) for o, step, size in product(("robot", "coffee_mug"), (20, 60), (0.05, 2.0))]
    cases += [Case("statue", 20, points=points, views=6) for points in (5000, 15_000, 45_000, 90_000)]
    cases += [Case(targets.ANCHOR, 20, points=targets.ANCHOR_POINTS, seed=s) for s in range(max(3, len(seeds)))]
    return cases


def slice_of_it() -> list[Case]:
    """What `--quick` registers."""
    cases = [Case(o, step, views=5) for o, step in product(("robot", "statue", "bowl"), (20, 40, 60))]
    cases += [Case("robot", 40, views=5, random_frames=True), Case("cap", 40, 0.0, views=3)]
    cases += [Case("helicopter", 20, views=5, path="uneven")]
    return [*cases, Case(targets.ANCHOR, 20, points=targets.ANCHOR_POINTS)]


def main() -> None:
    """Run and print it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="a slice, under five minutes on two cores")
    parser.add_argument("--seeds", type=int, default=1, help="how many")
    parser.add_argument("--peers", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--workers", type=int, default=2, help="sessions at a time, where only accuracy is measured")
    parser.add_argument("--json", type=Path, help="where to write every pair")
    options = parser.parse_args()
    started = time.perf_counter()
    chosen = choose((*METHODS, CONTROL), options.peers)
    cases = slice_of_it() if options.quick else whole(range(options.seeds))
    found = run_all([Job(case, *chosen) for case in cases], options.workers)
    if options.json:
        write_json(found, options.json)
    report(found, with_seconds=options.workers == 1)
    points, views = ([15_000], 6) if options.quick else ([5000, 15_000, 45_000, 90_000], 18)
    seconds = speed.report(points, views, options.peers)
    if not options.quick:
        print(flush=True)
        subprocess.run([sys.executable, "-m", "tests.benchmarks.memory"], check=False)
    targets.show(found, seconds)
    print(f"\n{len(found.pairs)} estimates in {(time.perf_counter() - started) / 60:.1f} minutes")


if __name__ == "__main__":
    main()
