"""Lost views and many views: `python -m tests.benchmarks.views lost`, and `... many --views 18,50,100,250`.

`lost` counts the views that are called failed though nothing is wrong with them: in even, uneven, random and shuffled
sessions, and in such where something else is in one view, or two parts see nothing in common. `many` tells what a view
costs as they become more; each session has a process of its own.
"""

import argparse
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from orbitscan.processing.pipeline import process
from orbitscan.processing.pose_errors import with_errors
from orbitscan.processing.results.estimates import ViewEstimate
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.results.status import WRONG_DEG, WRONG_SHARE, Method, Status
from orbitscan.recorder.session import Session, in_memory
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks import sessions
from tests.benchmarks.memory import peak_of_this_process
from tests.benchmarks.symmetry_tables import show_interval
from tests.benchmarks.tables import print_table
from tests.benchmarks.workers import pool

METHODS = (Method.PAIRWISE, Method.REFINED)
Kind = Literal["even", "uneven", "random", "shuffled", "foreign first", "foreign middle", "foreign last", "parts"]
KINDS: tuple[Kind, ...] = (
    "even", "uneven", "random", "shuffled", "foreign first", "foreign middle", "foreign last", "parts",
)  # fmt: skip
LIMITS = {Method.PAIRWISE: 0.05, Method.REFINED: 0.02}  # of right views called failed
MANY = ("bin", "robot", "coffee_mug")
STEP = 20


@dataclass(frozen=True)
class Lost:
    """A session, and how many of its own views each method places; those of `parts` in either of two components."""

    object: str
    kind: Kind
    views: int
    failed: dict[Method, int]
    wrong: dict[Method, int]
    components: dict[Method, tuple[int, ...]]  # how many views each has


@dataclass(frozen=True)
class Cost:
    """What a session cost."""

    object: str
    views: int
    stream_s: float  # processor time
    joint_s: float
    peak_gb: float | None
    statuses: dict[Method, Counter[Status]]
    wrong: int


def make(name: str, kind: Kind) -> tuple[Session, set[int]]:
    """A session of a kind, and the views in it that show the object."""
    path = {"uneven": "uneven", "random": "random"}.get(kind, "turn")
    scan = sessions.build(sessions.Case(name, STEP, path=path))  # type: ignore[arg-type]
    session, count = scan.session, len(scan.session.names)
    order, foreign = list(range(count)), set[int]()
    if kind == "shuffled":
        order = np.random.default_rng(0).permutation(count).tolist()
    elif kind == "parts":
        order = [i for i in order if i * STEP < 90 or 180 <= i * STEP < 250]
    elif kind.startswith("foreign"):
        foreign = {{"first": 0, "middle": count // 2, "last": count - 1}[kind.split()[1]]}
    other = sessions.build(sessions.Case("bin" if name != "bin" else "robot", STEP)).session
    views = [(other if i in foreign else session).load(i) for i in order]
    renamed = [replace(view, index=k, name=f"view_{k:03d}", colors=None) for k, view in enumerate(views)]
    truth = {k: session.truth()[i] for k, i in enumerate(order) if i not in foreign}
    return in_memory(replace(session.info, views=len(order)), renamed, truth), set(range(len(order))) - foreign


def look(case: tuple[str, Kind]) -> Lost:
    """Register a session and count its views that are not placed, or wrongly."""
    session, own = make(*case)
    result = _finish(session)
    failed, wrong, components = {}, {}, {}
    for method in METHODS:
        found = result.reconstruction[method]
        held = {view for component in found.components.values() for view in component}
        placed = set(found.placed) | (held if case[1] == "parts" else set())
        failed[method] = len(own - placed)
        wrong[method] = sum(_is_wrong(view, session) for view in found.views if view.status == Status.OK)
        wrong[method] += len(set(found.placed) - own)
        components[method] = (len(found.placed), *map(len, found.components.values()))
    return Lost(*case, len(own), failed, wrong, components)


def measure(case: tuple[str, int]) -> Cost:
    """Register a turn of so many views and tell what it costs."""
    name, count = case
    session = simulate(name, views=count)
    for _ in process(session.views([0, 1]), session.info, methods=METHODS):
        pass  # compiles
    marks = [time.process_time()]
    for result in with_errors(process(session.views(), session.info, methods=METHODS), session.truth()):
        marks.append(time.process_time())
        last = result
    assert isinstance(last, SessionResult)
    statuses = {method: Counter(v.status for v in last.reconstruction[method].views) for method in METHODS}
    wrong = sum(_is_wrong(v, session) for v in last.reconstruction[Method.REFINED].views if v.status == Status.OK)
    return Cost(name, count, marks[-2] - marks[0], marks[-1] - marks[-2], peak_of_this_process(), statuses, wrong)


def _finish(session: Session) -> SessionResult:
    *_, last = with_errors(process(session.views(), session.info, methods=METHODS), session.truth())
    assert isinstance(last, SessionResult)
    return last


def _is_wrong(view: ViewEstimate, session: Session) -> bool:
    degrees, metres = view.errors.rotation_error_deg, view.errors.center_error_m
    diameter = float(np.linalg.norm(np.ptp(session.load(view.view).points, axis=0)))
    return degrees is None or metres is None or degrees > WRONG_DEG or metres > WRONG_SHARE * diameter


def report_lost(found: Sequence[Lost]) -> None:
    """A row for each kind of session, and all that fails."""
    rows = []
    for kind in KINDS:
        of_kind = [lost for lost in found if lost.kind == kind]
        if of_kind:
            rows.append([kind, len(of_kind), sum(lost.views for lost in of_kind), *_count(of_kind)])
    counts = [f"{word}, {method}" for method in METHODS for word in ("failed", "wrong")]
    print_table(["sessions", "", "views", *counts], rows)
    print()
    for method, limit in LIMITS.items():
        failed, views = sum(lost.failed[method] for lost in found), sum(lost.views for lost in found)
        verdict = "met" if failed <= limit * views else "NOT MET"
        print(f"{method}: right views called failed {show_interval(failed, views)}, at most {limit:.0%}: {verdict}")
    for lost in found:
        if any(lost.failed.values()) or any(lost.wrong.values()) or lost.kind == "parts":
            told = "; ".join(
                f"{m} {lost.failed[m]} failed, {lost.wrong[m]} wrong, components {lost.components[m]}" for m in METHODS
            )
            print(f"{lost.object}, {lost.kind}: {told}")


def _count(found: Sequence[Lost]) -> Iterator[int]:
    for method in METHODS:
        yield sum(lost.failed[method] for lost in found)
        yield sum(lost.wrong[method] for lost in found)


def report_many(found: Iterable[Cost]) -> None:
    """A row for each session: processor time, memory, and what became of the views."""
    rows = []
    for cost in found:
        total = cost.stream_s + cost.joint_s
        told = ", ".join(f"{status} {count}" for status, count in cost.statuses[Method.REFINED].items())
        seconds = f"{cost.stream_s:.0f}", f"{cost.joint_s:.0f}", f"{total:.0f}", f"{total / cost.views:.2f}"
        peak = "?" if cost.peak_gb is None else f"{cost.peak_gb:.2f}"
        rows.append([f"{cost.object}, {cost.views} views", *seconds, peak, told, cost.wrong])
    print_table(["processor time [s]", "stream", "joint", "all", "a view", "peak [GB]", "refined", "wrong"], rows)


def main() -> None:
    """Run what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("lost", "many"))
    parser.add_argument("--objects", help="default: those without a symmetry for `lost`, bin, robot, coffee_mug")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--views", default="18,50,100,250")
    parser.add_argument("--workers", type=int, default=2, help="of `lost`; `many` runs one session after the other")
    options = parser.parse_args()
    if options.what == "lost":
        names = options.objects.split(",") if options.objects else sessions.ASYMMETRIC
        cases = [(name, kind) for name in names for kind in KINDS if kind in options.kinds.split(",")]
        with pool(options.workers) as workers:
            report_lost(list(workers.map(look, cases)))
        return
    costs: list[Cost] = []
    for name in options.objects.split(",") if options.objects else MANY:
        for count in map(int, options.views.split(",")):
            with pool(1) as alone:
                costs.append(alone.submit(measure, (name, count)).result())
            report_many(costs[-1:])
    print()
    report_many(costs)


if __name__ == "__main__":
    main()
