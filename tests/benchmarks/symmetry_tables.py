"""The tables of a run over objects that repeat themselves, and what it must show."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.stats import binomtest

from orbitscan.processing.results.status import WRONG_DEG, WRONG_SHARE, Status
from tests.benchmarks.solids import SOLIDS
from tests.benchmarks.symmetry_scores import KINDS, RUN, SCORE, Found, PairScore, Score, ViewScore
from tests.benchmarks.tables import print_table

AXIS_DEG, ORDER_SHARE, ORBIT_SHARE, OK_VIEWS = 1.0, 0.95, 0.99, 1000  # what it must show
LEGEND = f"""
views       all but the first of a session, which is where it is by definition
ok, wrong   called ok; of these, off by more than {WRONG_DEG:g} degrees or {100 * WRONG_SHARE:g} % of the diameter
in orbit    ambiguous pairs that are right once the motions or turns that they leave open are granted
in bound    of the others, those off by no more than they say
order       that the whole session declares about the vertical axis: exact, a multiple or divisor of it, another one,
            none, or any turn"""


def wrong(score: Score, method: str) -> list[ViewScore]:
    """The views of a session that are called ok and are not."""
    return [view for view in score.methods[method].views if view.status == Status.OK and is_off(view, score.diameter)]


def in_orbit(score: Score, pair: PairScore) -> bool:
    """Whether the truth is among the poses that a pair leaves open."""
    return not is_off(pair, score.diameter)


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
        "sessions": [SCORE.dump_python(score, mode="json") for score in found.scores],
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
        rows.append([name, len(mine), len(statuses), ambiguous, ok, bad, show_interval(bad, ok)])
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
        rows.append([name, len(pairs), sum(granted), bound, len(pairs) - held, show_interval(held, len(pairs))])
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
        rows.append(
            [f"{method}: wrong of ok views, solids and mugs", "0", show_interval(bad, ok), _verdict(not bad, ok)]
        )
        if not quick:
            rows.append([f"{method}: of these views", f">= {OK_VIEWS:,}", ok, _verdict(ok >= OK_VIEWS, symmetric)])
        pairs = sum(len(_ambiguous(score, method)) for score in symmetric)
        held = pairs - sum(len(outside(score, method)) for score in symmetric)
        limit, met = f">= {100 * ORBIT_SHARE:g} %", held >= ORBIT_SHARE * pairs
        rows.append([f"{method}: truth in orbit or bound", limit, show_interval(held, pairs), _verdict(met, pairs)])
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
    rows.append([what, limit, show_interval(sum(told), len(told)), _verdict(met, told)])
    rows.append(["sessions that broke", "0", len(found.broken), _verdict(not found.broken, True)])
    return Table("what it must show", ("", "limit", "measured", ""), rows)


def show_interval(count: int, of: int) -> str:
    """A share with its 95 % interval (Clopper-Pearson, which is never too narrow)."""
    if not of:
        return "none of none"
    low, high = binomtest(count, of).proportion_ci(method="exact")
    return f"{count} of {of} = {100 * count / of:.2f} % ({100 * low:.2f} to {100 * high:.2f})"


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


def is_off(entry: ViewScore | PairScore, diameter: float) -> bool:
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
