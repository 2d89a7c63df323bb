"""What the project promises of its registration, beside what a run measured."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from tests.benchmarks.registration import Found
from tests.benchmarks.scores import PairScore
from tests.benchmarks.sessions import ASYMMETRIC
from tests.benchmarks.tables import interval, print_table

ROUND = ("bin", "bowl", "water_bottle")
ANCHOR = "robot"  # an object of 32 to 38 cm
ANCHOR_POINTS = 15_000
SPEED_POINTS = 15_000

Rows = list[tuple[str, str, str, str]]  # what, limit, measured, verdict


def show(found: Found, seconds: Mapping[tuple[str, int], float]) -> None:
    """A line for each promise, for `pairwise` and, where it was run, `refined`."""
    rows: Rows = []
    for method in ("pairwise", "refined"):
        pairs = [pair for pair in found.pairs if pair.method == method]
        if pairs:
            _accuracy(rows, method, pairs)
            _reliability(rows, method, pairs)
    _chains(rows, found)
    _speed(rows, seconds)
    print("\nwhat it must show\n")
    print_table(["", "limit", "measured", ""], rows)


def _accuracy(rows: Rows, method: str, pairs: Sequence[PairScore]) -> None:
    ratios = [p.ratio for p in pairs if p.ok and p.ratio is not None]
    _add(rows, f"{method}: error / floor of ok pairs, median", 1.2, ratios, np.median)
    _add(rows, f"{method}: error / floor of ok pairs, 95 %", 2.9, ratios, lambda values: np.percentile(values, 95))
    exact = [p.determined_deg for p in pairs if p.ok and p.case.noise == 0]
    _add(rows, f"{method}: degrees without noise, median of ok pairs", 0.01, exact, np.median)
    anchor = [p.observable_deg for p in pairs if _is_anchor(p) and p.observable_deg is not None]
    _add(rows, f"{method}: anchor, degrees, median", 0.02, anchor, np.median)
    _add(rows, f"{method}: anchor, degrees, max", 0.1, anchor, np.max)


def _reliability(rows: Rows, method: str, pairs: Sequence[PairScore]) -> None:
    near = [p for p in pairs if not p.case.random_frames and p.case.path == "turn"]
    for step in (20, 40):
        chosen = [p for p in near if p.case.object in ASYMMETRIC and p.case.step == step]
        _count(rows, f"{method}: wrong at {step} degrees, no symmetry", chosen, lambda p: not p.right, "0")
        _count(rows, f"{method}: of these called ok", chosen, lambda p: p.ok and not p.right, "0")
    turning = [p for p in near if p.case.object in ROUND]
    _count(rows, f"{method}: wrong on {', '.join(ROUND)}", turning, lambda p: not p.right, "0")
    for what, chosen in (
        ("60 degrees", [p for p in near if p.case.step == 60]),
        ("random frames", [p for p in pairs if p.case.random_frames]),
    ):
        _share(rows, f"{method}: right at {what}", chosen, [p for p in chosen if p.right], 0.95)
    paths = {path: [p for p in pairs if p.case.path == path] for path in ("uneven", "random")}
    for what, chosen in (("", pairs), *((f", {path} path", mine) for path, mine in paths.items())):
        ok = [p for p in chosen if p.ok]
        told = [p for p in chosen if p.right and not p.free_motions]  # the others cannot be ok: a motion is free
        enough = "" if what else " (at least 1,000)"
        _share(rows, f"{method}: right among ok{enough}{what}", ok, [p for p in ok if p.right], 0.995)
        _share(rows, f"{method}: ok among right, where no motion is free{what}", told, [p for p in told if p.ok], 0.98)


def _chains(rows: Rows, found: Found) -> None:
    chosen = [s for s in found.sessions if s.method == "refined"]
    ratios = [s.chain_ratio for s in chosen if s.chain_ratio is not None]
    _add(rows, "refined: max chordal / floor of a chain with known shape, median", 3, ratios, np.median)
    anchor = [s.max_chordal for s in chosen if _is_anchor(s) and s.max_chordal is not None]
    _add(rows, "refined: anchor, max chordal", 0.002, anchor, np.median)


def _speed(rows: Rows, seconds: Mapping[tuple[str, int], float]) -> None:
    pair = seconds.get(("pairwise", SPEED_POINTS))
    joint = seconds.get(("refined", SPEED_POINTS))
    _add(rows, f"pairwise: seconds a pair at {SPEED_POINTS:,} points", 0.10, [pair] if pair else [], np.median)
    _add(rows, "refined: seconds a view more", 0.10, [joint - pair] if pair and joint else [], np.median)


def _is_anchor(score: Any) -> bool:
    case = score.case
    usual = case.step == 20 and case.noise == 1 and case.size is None and case.views is None and case.path == "turn"
    return usual and not case.random_frames and case.object == ANCHOR and case.points == ANCHOR_POINTS


def _add(rows: Rows, what: str, limit: float, values: Iterable[float], statistic: Callable[[Any], float]) -> None:
    """A number that must not exceed its limit."""
    values = list(values)
    if not values:
        rows.append((what, f"<= {limit:g}", "not measured", ""))
        return
    value = float(statistic(values))
    rows.append((what, f"<= {limit:g}", f"{value:.3g} (of {len(values)})", _verdict(value <= limit)))


def _count(rows: Rows, what: str, pairs: Sequence[PairScore], bad: Callable[[PairScore], bool], limit: str) -> None:
    """How many of the pairs are bad, of which there must be none."""
    found = sum(map(bad, pairs))
    rows.append(
        (what, limit, f"{found} of {len(pairs)}" if pairs else "not measured", _verdict(not found) * bool(pairs))
    )


def _share(rows: Rows, what: str, of: Sequence[PairScore], good: Sequence[PairScore], limit: float) -> None:
    """A share that must reach its limit."""
    verdict = _verdict(len(good) >= limit * len(of)) if of else ""
    rows.append((what, f">= {100 * limit:g} %", interval(len(good), len(of)), verdict))


def _verdict(met: bool) -> str:
    return "met" if met else "NOT MET"
