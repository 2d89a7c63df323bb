"""Whether `ok` can be believed on objects that repeat themselves: `make bench-symmetry`, or `QUICK=--quick` of it.

Solids with turns that nothing tells apart, mugs that only their handle tells apart, and objects without any symmetry;
each without the camera's step and with it. Sessions are kept in a file as they finish; with `--resume FILE` those in it
are not run again, whatever code they were run with: begin another file after a change. The whole takes some four hours
on two cores.
"""

import argparse
import json
import os
import random
import sys
import tempfile
import time
import traceback
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import TypeAdapter, ValidationError
from rich.console import Console
from rich.progress import track
from scipy.stats import binomtest

from orbitscan.processing.pipeline import process
from orbitscan.processing.pose_errors import with_errors
from orbitscan.processing.results.estimates import Freedom, MethodResult, PairEstimate, Symmetry, ViewEstimate
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.results.status import WRONG_DEG, WRONG_SHARE, Status
from orbitscan.processing.settings import Settings
from orbitscan.processing.surface.preparation import choose_scale
from orbitscan.recorder.session import Session, in_memory
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.sessions import ASYMMETRIC
from tests.benchmarks.solids import SOLIDS
from tests.benchmarks.tables import print_table

RUN = ("pairwise", "refined")
STEPS = (10, 20, 30, 45, 60, 90)  # degrees between successive views, of a whole turn
NOISE = (0.5, 1.0, 2.0)  # of the depth at 1 m [mm]
MUG, MUGS, MUG_STEP = "coffee_mug", range(1, 9), 30
KINDS = ("solids", "mugs", "controls")
VERTICAL_DEG = 10.0  # an axis so near to the vertical is meant to be it
AXIS_DEG, ORDER_SHARE, ORBIT_SHARE, OK_VIEWS = 1.0, 0.95, 0.99, 1000  # what it must show
LEGEND = f"""
views       all but the first of a session, which is where it is by definition
ok, wrong   called ok; of these, off by more than {WRONG_DEG:g} degrees or {100 * WRONG_SHARE:g} % of the diameter
in orbit    ambiguous pairs that are right once the motions or turns that they leave open are granted
in bound    of the others, those off by no more than they say
order       that the whole session declares about the vertical axis: exact, a multiple or divisor of it, another one,
            none, or any turn"""


@dataclass(frozen=True)
class Case:
    """All that makes a session."""

    object: str  # a solid, or an object of the simulation
    step: int  # degrees between successive views, of a whole turn
    noise: float = 1.0  # of the depth at 1 m [mm]
    known: bool = False  # whether the step is told
    instance: int = 1
    sensor: Literal["gaussian", "kinect"] = "gaussian"
    seed: int = 0

    @property
    def views(self) -> int:
        """How many there are."""
        return 360 // self.step

    @property
    def kind(self) -> str:
        """One of KINDS."""
        return "solids" if self.object in SOLIDS else "mugs" if self.object == MUG else "controls"

    @property
    def has_relief(self) -> bool:
        """Whether a solid's relief exceeds the noise: below, it may as well be round."""
        return self.object in SOLIDS and 1e3 * SOLIDS[self.object].relief > self.noise

    def __str__(self) -> str:
        name = f"{self.object} {self.instance}" if self.object == MUG else self.object
        extras = [f"seed {self.seed}" * bool(self.seed), self.sensor * (self.sensor != "gaussian")]
        told = f"{self.step} deg{' known' * self.known}"
        return ", ".join(filter(None, [f"{name} {told} {self.noise:g} mm", *extras]))


@dataclass(frozen=True)
class ViewScore:
    """A placed view against the truth; None where it has no pose."""

    view: int
    status: Status
    degrees: float | None
    metres: float | None  # of the object's centre
    bound_deg: float | None
    bound_m: float | None


@dataclass(frozen=True)
class Axis:
    """What a pair or a whole session declares: a symmetry, with its order, or a free turn or shift, with None."""

    order: int | None
    kind: Literal["symmetry", "turn", "shift"]
    off_deg: float  # of the axis from the vertical

    def __str__(self) -> str:
        name = self.kind if self.order is None else f"order {self.order}"
        return f"{name} about an axis {self.off_deg:.3g} deg off the vertical"


@dataclass(frozen=True)
class PairScore:
    """A pair against the truth, what it declares open granted; None where it has no pose."""

    source: int
    target: int
    status: Status
    degrees: float | None
    metres: float | None
    bound_deg: float | None
    bound_m: float | None
    axes: tuple[Axis, ...]
    alternatives: int  # other poses


@dataclass(frozen=True)
class MethodScore:
    """A session by a method, and what it declares of the whole."""

    views: tuple[ViewScore, ...]  # all but the first
    pairs: tuple[PairScore, ...]
    axes: tuple[Axis, ...]

    @property
    def claims(self) -> int:
        """How many motions, symmetries and orders are declared, of pairs and of the whole."""
        return len(self.axes) + sum(len(pair.axes) for pair in self.pairs)

    @property
    def about_vertical(self) -> Axis | None:
        """What is declared about the vertical axis: any turn before the highest order; None: nothing."""
        upright = [axis for axis in self.axes if axis.kind != "shift" and axis.off_deg <= VERTICAL_DEG]
        return max(upright, key=lambda axis: (axis.order is None, axis.order or 0, -axis.off_deg), default=None)


@dataclass(frozen=True)
class Score:
    """A session by all methods."""

    case: Case
    diameter: float  # of the object as the views show it [m]
    seconds: float  # of processor time, for all methods together, rendering left out
    methods: Mapping[str, MethodScore]


_SCORE = TypeAdapter(Score)
Runner = Callable[[Case], Score]


@dataclass(frozen=True)
class Found:
    """The scores of sessions, and what broke."""

    scores: tuple[Score, ...]
    broken: tuple[str, ...]  # a line for each


def whole() -> list[Case]:
    """The sessions of a whole run, at most 600, in an order drawn once: a run cut short is a spread as well.

    Solids and controls: at 1 mm every step, known and not; at 30 degrees every noise, known and not; of the rest all
    where the step is not known, but for 10 degrees. Mugs: eight instances by both sensors, known and not.
    """
    cases = [
        Case(name, step, noise, known)
        for name, step, noise, known in product((*SOLIDS, *ASYMMETRIC), STEPS, NOISE, (False, True))
        if noise == 1 or step == 30 or (step > 10 and not known)
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


def run(case: Case) -> Score:
    """The session of a case by all methods, against the truth."""
    session, settings = build(case), Settings()
    if case.known:
        settings = replace(settings, pair=replace(settings.pair, step_deg=360 / case.views))
    views, truth = session.views(), session.truth()
    started = time.process_time()
    results = process(views, session.info, settings, RUN, seed=case.seed)
    (last,) = deque(results, maxlen=1)
    seconds = time.process_time() - started
    (result,) = with_errors([last], truth)
    assert isinstance(result, SessionResult)
    scale = choose_scale(views, settings.surface)
    if scale is None or result.origin is None:
        raise ValueError("no view has points enough")
    up = {view: T_object_camera[:3, :3].T @ (0.0, 0.0, 1.0) for view, T_object_camera in truth.items()}
    methods = {method.value: _score(found, result.origin, up) for method, found in result.reconstruction.items()}
    return Score(case, scale.diameter, seconds, methods)


def build(case: Case) -> Session:
    """The session of a case, all rendered."""
    how: dict[str, Any] = {"views": case.views, "sensor": case.sensor, "noise_mm": case.noise, "seed": case.seed}
    with tempfile.TemporaryDirectory() as folder:
        solid = SOLIDS.get(case.object)
        what = case.object if solid is None else solid.write(Path(folder))
        session = simulate(what, case.instance, **how)
    return in_memory(session.info, list(session.views()), session.truth())


def _score(found: MethodResult, origin: int, up: Mapping[int, np.ndarray]) -> MethodScore:
    """`up` is the object's vertical axis in the frame of every view."""
    return MethodScore(
        tuple(_score_view(view) for view in found.views if view.view != origin),
        tuple(_score_pair(pair, up[pair.target]) for pair in found.pairs),
        _score_axes(found, up[origin]),
    )


def _score_view(view: ViewEstimate) -> ViewScore:
    errors = view.errors
    bounds = view.rotation_bound_deg, view.center_bound_m
    return ViewScore(view.view, view.status, errors.rotation_error_deg, errors.center_error_m, *bounds)


def _score_pair(pair: PairEstimate, vertical: np.ndarray) -> PairScore:
    errors = pair.errors
    return PairScore(
        pair.source, pair.target, pair.status, errors.rotation_error_deg_observable, errors.center_error_m_observable,
        pair.rotation_bound_deg, pair.center_bound_m,
        _score_axes(pair, vertical), len(pair.alternatives),
    )  # fmt: skip


def _score_axes(found: PairEstimate | MethodResult, vertical: np.ndarray) -> tuple[Axis, ...]:
    declared: tuple[Symmetry | Freedom, ...] = (*found.symmetries, *found.freedoms)
    return tuple(_score_axis(motion, vertical) for motion in declared)


def _score_axis(declared: Symmetry | Freedom, vertical: np.ndarray) -> Axis:
    axis = np.asarray(declared.axis)
    off = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(axis, vertical)), abs(axis @ vertical))))
    if isinstance(declared, Symmetry):
        return Axis(declared.order, "symmetry", off)
    return Axis(None, declared.kind, off)


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
                file.write(_SCORE.dump_json(score).decode() + "\n")
                file.flush()
            else:
                broken.append(f"{case}: {score}")
    return Found(tuple(known[case] for case in cases if case in known), tuple(broken))


def read(kept: Path) -> dict[Case, Score]:
    """The scores in a file; without one, none. A line that was cut is no score."""
    found = {}
    for line in kept.read_text(encoding="utf-8").splitlines() if kept.exists() else ():
        try:
            score = _SCORE.validate_json(line)
        except ValidationError:
            continue
        found[score.case] = score
    return found


def _each(cases: Sequence[Case], workers: int, runner: Runner) -> Iterator[tuple[Case, Score | str]]:
    """Every case with its score, or with what broke it, as they finish; workers share the cores."""
    if workers == 1:
        yield from ((case, _try(case, runner)) for case in cases)
        return
    threads = str(max(1, (os.cpu_count() or 1) // workers))
    shared = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), threads)
    before = dict(os.environ)
    os.environ.update(shared)  # read by the libraries when a worker loads them
    try:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            jobs = {pool.submit(_try, case, runner): case for case in cases}
            for job in as_completed(jobs):
                yield jobs[job], job.result()
    finally:
        os.environ.clear()
        os.environ.update(before)


def _try(case: Case, runner: Runner) -> Score | str:
    """A case's score, or what broke it: a benchmark of hours must not end at one session."""
    try:
        return runner(case)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}: {error} ({where.filename}:{where.lineno})"


def wrong(score: Score, method: str) -> list[ViewScore]:
    """The views of a session that are called ok and are not."""
    return [view for view in score.methods[method].views if view.status == Status.OK and _is_off(view, score.diameter)]


def in_orbit(score: Score, pair: PairScore) -> bool:
    """Whether the truth is among the poses that a pair leaves open."""
    return not _is_off(pair, score.diameter)


def in_bound(score: Score, pair: PairScore) -> bool:
    """Whether a pair is off by no more than it says, or than is right."""
    if pair.degrees is None or pair.metres is None or pair.bound_deg is None or pair.bound_m is None:
        return False
    limit = WRONG_SHARE * score.diameter
    return pair.degrees <= max(pair.bound_deg, WRONG_DEG) and pair.metres <= max(pair.bound_m, limit)


def outside(score: Score, method: str) -> list[PairScore]:
    """The ambiguous pairs of a session whose truth lies neither in the orbit nor within the bound."""
    return [p for p in _ambiguous(score, method) if not (in_orbit(score, p) or in_bound(score, p))]


def name_order(score: Score) -> str:
    """How the order that `refined` declares of a solid about the vertical axis stands to the true one."""
    declared, true = score.methods["refined"].about_vertical, SOLIDS[score.case.object].order
    if declared is None:
        return "none"
    if declared.order is None:
        return "any"
    if declared.order == true:
        return "exact"
    return "multiple" if not declared.order % true or not true % declared.order else "another"


def interval(count: int, of: int) -> str:
    """A share with its 95 % interval (Clopper-Pearson, which is never too narrow)."""
    if not of:
        return "none of none"
    low, high = binomtest(count, of).proportion_ci(method="exact")
    return f"{count} of {of} = {100 * count / of:.2f} % ({100 * low:.2f} to {100 * high:.2f})"


@dataclass(frozen=True)
class Table:
    """What `print_table` prints, under a title."""

    title: str
    head: tuple[str, ...]
    rows: list[list[object]]


def tables(found: Found, quick: bool) -> list[Table]:
    """All tables of a run; a row without sessions is left out."""
    scores = found.scores
    return [_ok(scores), _orbits(scores), _orders(scores), _claims(scores), _seconds(scores), _targets(found, quick)]


def report(found: Found, quick: bool) -> None:
    """Print all tables of a run, and a line for every view and pair that is not what it says, and for what broke."""
    print(LEGEND)
    for table in tables(found, quick):
        print(f"\n{table.title}\n")
        print_table(table.head, table.rows)
    lines = [*_lines(found, "wrong"), *_lines(found, "outside"), *(f"broken: {line}" for line in found.broken)]
    print("\n".join(["", *lines, ""] if lines else [""]))


def write_json(found: Found, quick: bool, path: Path) -> None:
    """The tables, what is listed below them and every session, as data."""
    content = {
        "tables": [asdict(table) for table in tables(found, quick)],
        "wrong": _lines(found, "wrong"),
        "outside": _lines(found, "outside"),
        "broken": found.broken,
        "sessions": [_SCORE.dump_python(score, mode="json") for score in found.scores],
    }
    path.write_text(json.dumps(content, indent=1), encoding="utf-8")


def _ok(scores: Sequence[Score]) -> Table:
    rows: list[list[object]] = []
    for method, known, kind in product(RUN, (False, True), KINDS):
        if not (mine := _where(scores, known, kind)):
            continue
        statuses = [view.status for score in mine for view in score.methods[method].views]
        ok, bad = statuses.count(Status.OK), sum(len(wrong(score, method)) for score in mine)
        name = f"{method}, {kind}, {_told(known)}"
        ambiguous = statuses.count(Status.AMBIGUOUS)
        rows.append([name, len(mine), len(statuses), ambiguous, ok, bad, interval(bad, ok)])
    return Table("views", ("", "sessions", "views", "ambiguous", "ok", "wrong", "wrong of ok (95 %)"), rows)


def _orbits(scores: Sequence[Score]) -> Table:
    rows: list[list[object]] = []
    for method, known, kind in product(RUN, (False, True), KINDS):
        if not (mine := _where(scores, known, kind)):
            continue
        pairs = [(score, pair) for score in mine for pair in _ambiguous(score, method)]
        granted = [in_orbit(*pair) for pair in pairs]
        bound = sum(not right and in_bound(*pair) for right, pair in zip(granted, pairs, strict=True))
        held = sum(granted) + bound
        name = f"{method}, {kind}, {_told(known)}"
        rows.append([name, len(pairs), sum(granted), bound, len(pairs) - held, interval(held, len(pairs))])
    return Table("ambiguous pairs", ("", "pairs", "in orbit", "in bound", "outside", "in either (95 %)"), rows)


def _orders(scores: Sequence[Score]) -> Table:
    rows = []
    groups: list[tuple[str, list[Score]]] = []
    for known in (False, True):
        solids = _where(scores, known, "solids")
        if not known:
            groups += [(f"{name}, {_told(known)}", [s for s in solids if s.case.object == name]) for name in SOLIDS]
        groups.append((f"all, {_told(known)}", solids))
        groups.append((f"relief above noise, {_told(known)}", [s for s in solids if s.case.has_relief]))
    for name, mine in (group for group in groups if group[1]):
        named, off = [name_order(score) for score in mine], _off(mine)
        counts = [named.count(word) for word in ("exact", "multiple", "another", "none", "any")]
        rows.append([name, len(mine), *counts, _number(off, 50), _number(off, 95)])
    head = "", "sessions", "exact", "multiple", "another", "none", "any", "axis off deg, median", "95 %"
    return Table("order about the vertical axis that refined declares of solids", head, rows)


def _claims(scores: Sequence[Score]) -> Table:
    rows: list[list[object]] = []
    for method, known in product(RUN, (False, True)):
        if not (mine := [score.methods[method] for score in _where(scores, known, "controls")]):
            continue
        pairs = [pair for score in mine for pair in score.pairs]
        counts = [
            sum(any(axis.kind != "symmetry" for axis in pair.axes) for pair in pairs),
            sum(any(axis.kind == "symmetry" for axis in pair.axes) for pair in pairs),
            sum(axis.kind != "symmetry" for score in mine for axis in score.axes),
            sum(axis.kind == "symmetry" for score in mine for axis in score.axes),
        ]
        rows.append([f"{method}, {_told(known)}", len(mine), len(pairs), *counts])
    head = "", "sessions", "pairs", "pairs free", "pairs with order", "freedoms of whole", "symmetries of whole"
    return Table("declared of objects without symmetry, where nothing may be", head, rows)


def _seconds(scores: Sequence[Score]) -> Table:
    rows: list[list[object]] = []
    for known, kind in product((False, True), KINDS):
        if not (mine := _where(scores, known, kind)):
            continue
        seconds = [score.seconds for score in mine]
        each = [score.seconds / score.case.views for score in mine]
        shown = [_number(values, at) for values, at in ((seconds, 50), (each, 50), (each, 95))]
        rows.append([f"{kind}, {_told(known)}", len(mine), *shown, f"{sum(seconds):.0f}"])
    head = "", "sessions", "a session, median", "a view, median", "95 %", "all"
    return Table("seconds of processor time, both methods", head, rows)


def _targets(found: Found, quick: bool) -> Table:
    scores = found.scores
    symmetric = [score for score in scores if score.case.kind != "controls"]
    controls = [score for score in scores if score.case.kind == "controls"]
    rows: list[list[object]] = []
    for method in RUN:
        ok = sum(view.status == Status.OK for score in symmetric for view in score.methods[method].views)
        bad = sum(len(wrong(score, method)) for score in symmetric)
        rows.append([f"{method}: wrong of ok views, solids and mugs", "0", interval(bad, ok), _verdict(not bad, ok)])
        if not quick:
            rows.append([f"{method}: of these views", f">= {OK_VIEWS:,}", ok, _verdict(ok >= OK_VIEWS, symmetric)])
        pairs = sum(len(_ambiguous(score, method)) for score in symmetric)
        held = pairs - sum(len(outside(score, method)) for score in symmetric)
        limit, met = f">= {100 * ORBIT_SHARE:g} %", held >= ORBIT_SHARE * pairs
        rows.append([f"{method}: truth in orbit or bound", limit, interval(held, pairs), _verdict(met, pairs)])
        bad = sum(score.methods[method].claims for score in controls)
        shown = f"{bad} in {len(controls)} sessions" if controls else "not measured"
        rows.append([f"{method}: motions and orders declared of controls", "0", shown, _verdict(not bad, controls)])
    off = _off(scores)
    shown = f"{_number(off, 95)} (of {len(off)}, worst {max(off):.3g})" if off else "not measured"
    met = bool(off) and float(np.percentile(off, 95)) <= AXIS_DEG
    rows.append(["refined: axis off, degrees, 95 %", f"<= {AXIS_DEG:g}", shown, _verdict(met, off)])
    told = [name_order(score) == "exact" for score in _where(scores, False, "solids") if score.case.has_relief]
    limit, met = f">= {100 * ORDER_SHARE:g} %", sum(told) >= ORDER_SHARE * len(told)
    what = "refined: order exact, relief above noise, step unknown"
    rows.append([what, limit, interval(sum(told), len(told)), _verdict(met, told)])
    rows.append(["sessions that broke", "0", len(found.broken), _verdict(not found.broken, True)])
    return Table("what it must show", ("", "limit", "measured", ""), rows)


def _verdict(met: bool, measured: object) -> str:
    """Nothing where nothing was measured."""
    return ("met" if met else "NOT MET") * bool(measured)


def _lines(found: Found, which: Literal["wrong", "outside"]) -> list[str]:
    """What is wrong though ok, views; or outside of its orbit and bound, pairs: with what reproduces it."""
    lines = []
    for score, method in product(found.scores, RUN):
        off: Sequence[ViewScore | PairScore] = (wrong if which == "wrong" else outside)(score, method)
        for entry in off:
            what = f"view {entry.view}" if isinstance(entry, ViewScore) else f"view {entry.source} to {entry.target}"
            known = [
                f"{name} {1e3 * value:.3g} mm" if in_metres else f"{name} {value:.3g} deg"
                for name, value, in_metres in (
                    ("off", entry.degrees, False),
                    ("centre", entry.metres, True),
                    ("bounds", entry.bound_deg, False),
                    ("and", entry.bound_m, True),
                )
                if value is not None
            ]
            known += [f"declares {axis}" for axis in getattr(entry, "axes", ())]
            lines.append(f"{which}: {method}, {score.case}, {what}: {', '.join(known) or 'no pose'}")
    return lines


def _is_off(entry: ViewScore | PairScore, diameter: float) -> bool:
    """Whether it is off the truth by more than is right, or has no pose."""
    if entry.degrees is None or entry.metres is None:
        return True
    return entry.degrees > WRONG_DEG or entry.metres > WRONG_SHARE * diameter


def _ambiguous(score: Score, method: str) -> list[PairScore]:
    return [pair for pair in score.methods[method].pairs if pair.status == Status.AMBIGUOUS]


def _where(scores: Iterable[Score], known: bool, kind: str) -> list[Score]:
    return [score for score in scores if score.case.known == known and score.case.kind == kind]


def _off(scores: Iterable[Score]) -> list[float]:
    """By how many degrees the vertical axes that `refined` declares of solids are off."""
    declared = [s.methods["refined"].about_vertical for s in scores if s.case.kind == "solids"]
    return [axis.off_deg for axis in declared if axis is not None]


def _told(known: bool) -> str:
    return "step known" if known else "step unknown"


def _number(values: Sequence[float], percentile: float) -> str:
    return f"{np.percentile(values, percentile):.3g}" if values else "-"


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
