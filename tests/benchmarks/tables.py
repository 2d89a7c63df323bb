"""What a run shows: a row for each method and peer with ratios to `pairwise`, and every pair wrong but called ok."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from scipy.stats import binomtest

from tests.benchmarks.scores import PairScore, SessionScore

REFERENCE = "pairwise"  # what ratios are to
LEGEND = """
pairs       estimates wanted; ok: called ok (a peer calls every pose ok); wrong ok: of these, wrong; right %: of all
not ok      right, with no motion free, but not called ok
deg, mm     rotation and centre error over all estimates, the motions declared free taken out; x: times pairwise's
/floor      error / floor of the ok pairs, rotation and centre, what the surfaces leave free taken out of both
chordal     largest of all T_0_i, median over sessions; /chain: times the floor of a chain with known shape
s/pair      median seconds from points to pose, a view prepared once"""


def show(pairs: Sequence[PairScore], wholes: Sequence[SessionScore], with_seconds: bool) -> None:
    """Print all tables of a run: by each property in which its sessions differ, then of all."""
    print(LEGEND)
    for name in ("noise", "size", "points", "random_frames", "path", "step"):
        values = {getattr(pair.case, name) for pair in pairs}
        for value in sorted(values, key=str) if len(values) > 1 else ():
            chosen = _where(pairs, **{name: value}), _where(wholes, **{name: value})
            show_methods(f"{name.replace('_', ' ')}: {value}", *chosen, with_seconds)
    show_methods("all", pairs, wholes, with_seconds)
    show_objects(pairs)
    show_wrong(pairs)


def show_methods(
    title: str, pairs: Sequence[PairScore], wholes: Sequence[SessionScore], with_seconds: bool = True
) -> None:
    """A row for each method."""
    reference = _where(pairs, method=REFERENCE)
    rows = []
    for method in _methods(pairs):
        mine, whole = _where(pairs, method=method), _where(wholes, method=method)
        ok, right = _where(mine, ok=True), _where(mine, right=True)
        degrees, ratios = _values(mine, "observable_deg"), _values(ok, "ratio")
        seconds = _values(mine if with_seconds else [], "seconds")
        rows.append([
            method, len(mine), len(ok), sum(not p.right for p in ok), f"{100 * len(right) / len(mine):.1f}",
            sum(not p.ok and not p.free_motions for p in right),
            *(_number(f, degrees) for f in (np.median, _high, np.max)),
            _quotient(degrees, _values(reference, "observable_deg")),
            _number(np.median, _values(mine, "observable_mm")),
            _number(np.median, ratios), _number(_high, ratios), _number(np.median, _values(ok, "center_ratio")),
            _number(np.median, _values(whole, "max_chordal")), _number(np.median, _values(whole, "chain_ratio")),
            _number(np.median, seconds), _quotient(seconds, _values(reference, "seconds")),
        ])  # fmt: skip
    head = [
        "", "pairs", "ok", "wrong ok", "right %", "not ok", "deg med", "95 %", "max", "x", "mm med",
        "/floor", "95 %", "mm/floor", "chordal", "/chain", "s/pair", "x",
    ]  # fmt: skip
    print(f"\n{title}\n")
    print_table(head, rows)


def show_objects(pairs: Sequence[PairScore]) -> None:
    """For each object and step and each method: right of all, and how many wrong ones are called ok."""
    methods = _methods(pairs)
    rows = []
    for name, step in sorted({(pair.case.object, pair.case.step) for pair in pairs}):
        cells = []
        for method in methods:
            mine = _where(pairs, object=name, step=step, method=method)
            right, wrong = sum(p.right for p in mine), sum(p.ok and not p.right for p in mine)
            cells.append(f"{right}/{len(mine)}" + f" {wrong} wrong ok" * bool(wrong) if mine else "-")
        rows.append([f"{name} {step}", *cells])
    print("\nright of all, by object and step in degrees\n")
    print_table(["", *methods], rows)


def show_wrong(pairs: Sequence[PairScore]) -> None:
    """How many ok pairs are right, and every one that is not, with what reproduces it (peers judge nothing)."""
    for method in _methods(pairs):
        mine = _where(pairs, method=method)
        if all(pair.confidence is None for pair in mine):
            continue
        ok, told = _where(mine, ok=True), _where(mine, right=True, free_motions=0)
        shares = interval(sum(p.right for p in ok), len(ok)), interval(sum(p.ok for p in told), len(told))
        print(f"\n{method}: right among ok {shares[0]}; ok among right where no motion is free {shares[1]}")
        for pair in ok:
            if not pair.right:
                evidence = ", ".join(f"{k} {_short(v)}" for k, v in pair.evidence.items() if v is not None)
                freedoms = ", ".join(freedom["kind"] for freedom in pair.freedoms)
                print(
                    f"  {pair.case}, view {pair.source} to {pair.target}: {_short(pair.observable_deg)} deg, "
                    f"{_short(pair.observable_mm)} mm; confidence {_short(pair.confidence)}, {evidence}"
                    + f"; declared free: {freedoms}"
                    * bool(freedoms)
                )


def interval(right: int, of: int) -> str:
    """A share with its 95 % interval (Wilson)."""
    if not of:
        return "none of none"
    low, high = binomtest(right, of).proportion_ci(method="wilson")
    return f"{right} of {of} = {100 * right / of:.2f} % ({100 * low:.2f} to {100 * high:.2f})"


def print_table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Columns as wide as they need; the first to the left."""
    text = [list(map(str, row)) for row in [head, *rows]]
    widths = [max(len(row[i]) for row in text) for i in range(len(head))]
    for row in text:
        cells = [row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))]
        print("  ".join(cells).rstrip())


def _methods(pairs: Iterable[PairScore]) -> list[str]:
    return list(dict.fromkeys(pair.method for pair in pairs))


def _where(scores: Iterable[Any], **wanted: object) -> list[Any]:
    """The scores of which all this is so, of them or of their case."""
    return [s for s in scores if all(getattr(s if hasattr(s, k) else s.case, k) == v for k, v in wanted.items())]


def _values(scores: Iterable[Any], name: str) -> np.ndarray:
    """What is known of a quantity."""
    return np.array([v for v in (getattr(score, name) for score in scores) if v is not None], dtype=float)


def _high(values: np.ndarray) -> float:
    return float(np.percentile(values, 95))


def _number(statistic: Callable[[np.ndarray], float], values: np.ndarray) -> str:
    return f"{statistic(values):.3g}" if len(values) else "-"


def _quotient(values: np.ndarray, reference: np.ndarray) -> str:
    return f"{np.median(values) / np.median(reference):.2f}" if len(values) and len(reference) else "-"


def _short(value: object) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)
