"""Registration, ours and the peers', side by side in one run: `make bench`, or this module with a choice of sessions.

python -m tests.benchmarks.registration --objects robot,bin --steps 20,40 --noise 1 --seeds 3 --no-peers
"""

import argparse
import json
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rich.progress import track

from processing.pipeline import process
from processing.results.records import METHODS, SessionResult
from processing.settings import Settings
from tests.benchmarks import peers, sessions, tables
from tests.benchmarks.scores import PairScore, SessionScore, score_pair, score_session
from tests.benchmarks.sessions import Case, Scan

CONTROL = "identity + our refiner"


@dataclass(frozen=True)
class Job:
    """A session, and what registers it."""

    case: Case
    methods: tuple[str, ...]
    peers: tuple[str, ...]


Scores = tuple[list[PairScore], list[SessionScore]]


def run(job: Job) -> Scores:
    """The scores of a session by every method and peer of a job."""
    scan = sessions.build(job.case)
    pairs, wholes = [], []
    ours = [method for method in job.methods if method != CONTROL]
    runs = [_ours(scan, ours, Settings(), {})] if ours else []
    if CONTROL in job.methods:
        runs.append(_ours(scan, ["pairwise"], control_settings(), {"pairwise": CONTROL}))
    runs += [_peer(scan, name) for name in job.peers]
    for found in runs:
        pairs += found[0]
        wholes += found[1]
    return pairs, wholes


def control_settings() -> Settings | None:
    """The settings of the control: `pairwise` with no start but the identity; None while there is no such setting."""
    try:
        return replace(Settings(), pair=replace(Settings().pair, starts=("identity",)))
    except TypeError:
        return None


def _ours(scan: Scan, methods: Sequence[str], settings: Settings, names: dict[str, str]) -> Scores:
    """The scores of our methods, under other names where given."""
    *views, result = process(scan.session.views(), scan.session.info, settings, methods, seed=scan.case.seed)
    assert isinstance(result, SessionResult)
    pairs, wholes = [], []
    for method in methods:
        found = result.reconstruction[method]
        seconds = {view.view: sum(view.seconds.get(method, {}).values()) for view in views}
        shown = names.get(method, method)
        pairs += [
            score_pair(
                scan,
                shown,
                pair.source,
                pair.target,
                pair.T_target_source,
                status=pair.status,
                freedoms=getattr(pair, "freedoms", ()),
                confidence=pair.confidence,
                evidence=asdict(pair.evidence),
                candidates=[asdict(candidate) for candidate in pair.candidates],
                seconds=seconds.get(pair.source),
            )
            for pair in found.pairs
        ]
        estimates = {view.view: view.T_0_i for view in found.views}
        wholes.append(score_session(scan, shown, estimates, found.failed_views, result.seconds["methods"][method]))
    return pairs, wholes


def _peer(scan: Scan, name: str) -> Scores:
    """The scores of a peer."""
    found = peers.run(name, scan.session)
    pairs = [
        score_pair(scan, name, *pair, T, freedoms=None, seconds=found.seconds[pair]) for pair, T in found.pairs.items()
    ]
    return pairs, [score_session(scan, name, found.poses, 0, found.stages)]


def run_all(jobs: Sequence[Job], workers: int) -> Iterator[Scores]:
    """The scores of all jobs, in their order."""
    if workers == 1:
        yield from map(run, jobs)
        return
    threads = str(max(1, (os.cpu_count() or 1) // workers))
    for name in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = threads  # read by the libraries when a worker loads them
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(run, jobs)


def main(arguments: Sequence[str] | None = None) -> None:
    """Register what the command line chooses, and print the tables."""
    options = _parse(arguments)
    methods = tuple(m for m in options.methods if m != CONTROL or control_settings())
    chosen = peers.available() if options.peers else ()
    jobs = [Job(case, methods, chosen) for case in _cases(options)]
    pairs, wholes = [], []
    for found in track(run_all(jobs, options.workers), "Registering", len(jobs), console=tables.progress_console()):
        pairs += found[0]
        wholes += found[1]
    if options.json:
        options.json.write_text(json.dumps(_plain(pairs, wholes), indent=1), encoding="utf-8")
    for line in peers.missing() if options.peers else ():
        print(line)
    if CONTROL in options.methods and CONTROL not in methods:
        print(f"{CONTROL}: there is no setting for it")
    tables.show(pairs, wholes)


def _cases(options: argparse.Namespace) -> list[Case]:
    """The product of all that is chosen."""
    return [
        Case(name, step, noise, seed, options.random_frames, size, points, options.views, options.outliers)
        for seed, name, step, noise, size, points in product(
            range(options.seeds), options.objects, options.steps, options.noise, options.sizes, options.points
        )
    ]


def _plain(pairs: Sequence[PairScore], wholes: Sequence[SessionScore]) -> dict[str, Any]:
    return {
        "pairs": [{**asdict(pair), "ratio": pair.ratio, "center_ratio": pair.center_ratio} for pair in pairs],
        "sessions": [asdict(whole) for whole in wholes],
    }


def _parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    def several(kind: type) -> Any:
        return lambda text: [kind(word) for word in text.split(",")]

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=several(str), default=list(sessions.available()))
    parser.add_argument("--steps", type=several(int), default=[20, 40, 60], help="degrees between views")
    parser.add_argument("--noise", type=several(float), default=[1.0], help="mm at 1 m")
    parser.add_argument("--seeds", type=int, default=1, help="how many")
    parser.add_argument("--sizes", type=several(float), default=[None], help="the object's diameter in m")
    parser.add_argument("--points", type=several(int), default=[None], help="a view, about")
    parser.add_argument("--views", type=int, help="only the first ones")
    parser.add_argument("--outliers", type=float, default=0.01, help="share of the points")
    parser.add_argument("--random-frames", action="store_true", help="every view turned at random")
    parser.add_argument("--methods", type=several(str), default=[*METHODS, CONTROL])
    parser.add_argument("--peers", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--workers", type=int, default=1, help="sessions at a time; timings are then of no use")
    parser.add_argument("--json", type=Path, help="where to write every pair")
    options = parser.parse_args(arguments)
    if unknown := [name for name in options.objects if name not in sessions.available()]:
        parser.error(f"no such object: {', '.join(unknown)}")
    return options


if __name__ == "__main__":
    sys.exit(main())
