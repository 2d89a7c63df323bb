"""Registration, ours and the peers', side by side in one run: `make bench`, or this module with a choice of sessions.

python -m tests.benchmarks.registration --objects robot,bin --steps 20,40 --noise 1 --seeds 3 --no-peers
"""

import argparse
import json
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track

from orbitscan.processing.pipeline import process
from orbitscan.processing.results.status import METHODS
from orbitscan.processing.settings import Settings
from tests.benchmarks import peers, sessions, tables
from tests.benchmarks.scores import PairScore, SessionScore, score_pair, score_session
from tests.benchmarks.sessions import Case, Scan
from tests.benchmarks.workers import pool

CONTROL = "identity + our refiner"


@dataclass(frozen=True)
class Job:
    """A session, and what registers it."""

    case: Case
    methods: tuple[str, ...]
    peers: tuple[str, ...]


@dataclass(frozen=True)
class Found:
    """The scores of sessions, and what broke."""

    pairs: tuple[PairScore, ...] = ()
    sessions: tuple[SessionScore, ...] = ()
    broken: tuple[str, ...] = ()  # a line for each

    def __add__(self, other: "Found") -> "Found":
        return Found(self.pairs + other.pairs, self.sessions + other.sessions, self.broken + other.broken)


def run(job: Job) -> Found:
    """A session by every method and peer of a job; one that raises does not keep the others from running."""
    scan = sessions.build(job.case)
    ours = tuple(method for method in job.methods if method != CONTROL)
    parts: list[tuple[str, Callable[[], Found]]] = []
    if ours:
        parts.append(("ours", lambda: _ours(scan, ours, Settings(), {})))
    if CONTROL in job.methods:
        parts.append((CONTROL, lambda: _ours(scan, ("pairwise",), control_settings(), {"pairwise": CONTROL})))
    if job.peers:
        parts.append(("peers", lambda: _peers(scan, job.peers)))
    found = Found()
    for name, part in parts:
        try:
            found += part()
        except Exception as error:  # a benchmark of an hour must not end at one session
            where = traceback.extract_tb(error.__traceback__)[-1]
            line = f"{name}, {job.case}: {type(error).__name__}: {error} ({where.filename}:{where.lineno})"
            found += Found(broken=(line,))
    return found


def control_settings() -> Settings | None:
    """The settings of the control: `pairwise` with no start but the identity; None while there is no such setting."""
    try:
        return replace(Settings(), pair=replace(Settings().pair, starts=("identity",)))
    except TypeError:
        return None


def _ours(scan: Scan, methods: Sequence[str], settings: Settings | None, names: Mapping[str, str]) -> Found:
    """A session by our methods, under other names where given."""
    *views, result = process(scan.session.views(), scan.session.info, settings, methods, seed=scan.case.seed)
    pairs, wholes = [], []
    for method in methods:
        found = result.reconstruction[method]
        shown = names.get(method, method)
        stages = result.seconds["methods"][method]
        seconds = {view.view: sum(view.seconds.get(method, {}).values()) for view in views}
        joint = (stages["total"] - sum(seconds.values())) / len(views)  # each view's share of what is done at the end
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
                seconds=seconds[pair.source] + joint,
            )
            for pair in found.pairs
        ]
        estimates = {view.view: view.T_0_i for view in found.views}
        wholes.append(score_session(scan, shown, estimates, found.failed_views, stages))
    return Found(tuple(pairs), tuple(wholes))


def _peers(scan: Scan, names: Sequence[str]) -> Found:
    """A session by peers."""
    pairs, wholes = [], []
    for name, found in peers.run(names, scan.session).items():
        pairs += [
            score_pair(scan, name, *pair, T, freedoms=None, seconds=found.seconds[pair])
            for pair, T in found.pairs.items()
        ]
        wholes.append(score_session(scan, name, found.poses, 0, found.stages))
    return Found(tuple(pairs), tuple(wholes))


def run_all(jobs: Sequence[Job], workers: int) -> Found:
    """All jobs, in their order; several at a time share the cores, and their seconds are then of no use."""
    found = Found()
    for part in track(_each(jobs, workers), "Registering", len(jobs), console=Console(file=sys.stderr)):
        found += part
    return found


def _each(jobs: Sequence[Job], workers: int) -> Iterator[Found]:
    if workers == 1:
        yield from map(run, jobs)
        return
    with pool(workers) as executor:
        yield from executor.map(run, jobs)


def report(found: Found, with_seconds: bool) -> None:
    """Print all tables of a run."""
    tables.show(found.pairs, found.sessions, with_seconds)
    for line in found.broken:
        print(f"broken: {line}")


def write_json(found: Found, path: Path) -> None:
    """Every pair and session, as data."""
    content = {
        "pairs": [{**asdict(pair), "ratio": pair.ratio, "center_ratio": pair.center_ratio} for pair in found.pairs],
        "sessions": [asdict(session) for session in found.sessions],
        "broken": found.broken,
    }
    path.write_text(json.dumps(content, indent=1, default=np.ndarray.tolist), encoding="utf-8")


def choose(methods: Sequence[str], with_peers: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The methods and peers there are, with a line for each that is not."""
    control = control_settings() is not None
    if CONTROL in methods and not control:
        print(f"{CONTROL}: there is no setting for it")
    for line in peers.missing() if with_peers else ():
        print(line)
    return tuple(m for m in methods if m != CONTROL or control), peers.available() if with_peers else ()


def main() -> None:
    """Register what the command line chooses, and print the tables."""
    options = _parse()
    chosen = choose(options.methods, options.peers)
    found = run_all([Job(case, *chosen) for case in _cases(options)], options.workers)
    if options.json:
        write_json(found, options.json)
    report(found, options.workers == 1)


def _cases(options: argparse.Namespace) -> list[Case]:
    """The product of all that is chosen."""
    return [
        Case(name, step, noise, seed, options.random_frames, size, points, options.views, options.outliers, path)
        for seed, path, name, step, noise, size, points in product(
            options.seeds, options.paths, options.objects, options.steps, options.noise, options.sizes, options.points
        )
    ]


def _parse() -> argparse.Namespace:
    def several(kind: type) -> Any:
        return lambda text: [kind(word) for word in text.split(",")]

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=several(str), default=list(sessions.available()))
    parser.add_argument("--steps", type=several(int), default=[20, 40, 60], help="degrees between views")
    parser.add_argument("--noise", type=several(float), default=[1.0], help="mm at 1 m")
    parser.add_argument("--seeds", type=_seeds, default=range(1), help="how many, or a range 3:5")
    parser.add_argument("--sizes", type=several(float), default=[None], help="the object's diameter in m")
    parser.add_argument("--points", type=several(int), default=[None], help="a view, about")
    parser.add_argument("--paths", type=several(str), default=["turn"], help="of the camera: turn, uneven, random")
    parser.add_argument("--views", type=int, help="only the first ones")
    parser.add_argument("--outliers", type=float, default=0.01, help="share of the points")
    parser.add_argument("--random-frames", action="store_true", help="every view turned at random")
    parser.add_argument("--methods", type=several(str), default=[*METHODS, CONTROL])
    parser.add_argument("--peers", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--workers", type=int, default=1, help="sessions at a time; timings are then of no use")
    parser.add_argument("--json", type=Path, help="where to write every pair")
    options = parser.parse_args()
    if unknown := [name for name in options.objects if name not in sessions.available()]:
        parser.error(f"no such object: {', '.join(unknown)}")
    return options


def _seeds(text: str) -> range:
    start, colon, stop = text.partition(":")
    return range(int(start), int(stop)) if colon else range(int(start))


if __name__ == "__main__":
    main()
