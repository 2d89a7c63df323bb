"""What a run shows: a row for each method and peer with ratios to `pairwise`, and every pair wrong but called ok."""

import sys
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from rich.console import Console
from scipy.stats import binomtest

from tests.benchmarks.scores import PairScore, SessionScore

REFERENCE = "pairwise"  # what ratios are to


def progress_console() -> Console:
    """Where progress is shown."""
    return Console(file=sys.stderr)


def show(pairs: Sequence[PairScore], wholes: Sequence[SessionScore]) -> None:
    """Print all tables of a run."""
    show_methods("All", pairs, wholes)
    for step in sorted({pair.case.step for pair in pairs}):
        show_methods(f"{step} degrees", _where(pairs, step=step), _where(wholes, step=step))
    show_wrong(pairs)


def show_methods(title: str, pairs: Sequence[PairScore], wholes: Sequence[SessionScore]) -> None:
    """A row for each method."""
    methods = list(dict.fromkeys(pair.method for pair in pairs))
    reference = _where(pairs, method=REFERENCE)
    rows = []
    for method in methods:
        mine, whole = _where(pairs, method=method), _where(wholes, method=method)
        ok, right = _where(mine, ok=True), _where(mine, right=True)
        degrees = _values(mine, "observable_deg")
        ratios, seconds = _values(ok, "ratio"), _values(mine, "seconds")
        rows.append([
            method, len(mine), len(ok), sum(not p.right for p in ok), f"{100 * len(right) / len(mine):.1f}",
            sum(not p.ok for p in right),
            *(_number(f, degrees) for f in (np.median, _high, np.max)),
            _quotient(np.median, degrees, _values(reference, "observable_deg")),
            _number(np.median, _values(mine, "observable_mm")),
            _number(np.median, ratios), _number(_high, ratios), _number(np.median, _values(ok, "center_ratio")),
            _number(np.max, _values(whole, "max_chordal")), _number(np.median, _values(whole, "chain_ratio")),
            _number(np.median, seconds), _quotient(np.median, seconds, _values(reference, "seconds")),
        ])  # fmt: skip
    head = [
        "", "pairs", "ok", "wrong ok", "right %", "not ok", "deg med", "95 %", "max", "x", "mm med",
        "/floor", "95 %", "mm/floor", "chordal", "/chain", "s/pair", "x",
    ]  # fmt: skip
    print(f"\n{title}\n")
    print_table(head, rows)


def show_wrong(pairs: Sequence[PairScore]) -> None:
    """Every pair of ours that is wrong but called ok, with what reproduces it; how many ok pairs are right."""
    for method in dict.fromkeys(pair.method for pair in pairs):
        mine = _where(pairs, method=method)
        ok, right = _where(mine, ok=True), _where(mine, right=True)
        both = sum(pair.ok and pair.right for pair in mine)
        print(f"\n{method}: right among ok {interval(both, len(ok))}, ok among right {interval(both, len(right))}")
        for pair in ok:
            if not pair.right and pair.confidence is not None:
                print(f"  {pair.case}: {pair.source} -> {pair.target}, {pair.observable_deg:.2f} deg, "
                      f"{pair.observable_mm:.2f} mm, confidence {pair.confidence:.3f}, {pair.evidence}")  # fmt: skip


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


def _where(scores: Iterable, **wanted: object) -> list:
    """The scores of which all this is so, of them or of their case."""
    return [s for s in scores if all(getattr(s if hasattr(s, k) else s.case, k) == v for k, v in wanted.items())]


def _values(scores: Iterable, name: str) -> np.ndarray:
    """What is known of a quantity."""
    return np.array([v for v in (getattr(score, name) for score in scores) if v is not None], dtype=float)


def _high(values: np.ndarray) -> float:
    return float(np.percentile(values, 95))


def _number(statistic: Callable, values: np.ndarray) -> str:
    return f"{statistic(values):.3g}" if len(values) else "-"


def _quotient(statistic: Callable, values: np.ndarray, reference: np.ndarray) -> str:
    return f"{statistic(values) / statistic(reference):.2f}" if len(values) and len(reference) else "-"
