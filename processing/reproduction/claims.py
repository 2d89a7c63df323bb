"""What the thesis claims, held against our runs: it holds, it does not, or it cannot be told."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy import stats

FEWEST_RUNS = 3  # an interval over fewer tells nothing
CONFIDENCE = 0.95


class Verdict(StrEnum):
    """What our runs say of a claim."""

    HOLDS = "holds"
    FAILS = "does not hold"
    OPEN = "cannot be told"


@dataclass(frozen=True)
class Claim:
    """A claim that a mean difference is positive, the verdict, and the numbers it rests on."""

    text: str
    verdict: Verdict
    difference: float | None = None  # mean over the pairs; None where there is no pair
    interval: tuple[float, float] | None = None  # of the mean, at CONFIDENCE; None where there are too few pairs
    runs: int = 0  # how many pairs there are
    unit: str = ""  # of the difference
    pair: str = "run"  # what gives a pair
    missing: str = ""  # why there is no pair

    @property
    def evidence(self) -> str:
        """The numbers behind the verdict, in words that stand between brackets."""
        if self.difference is None:
            return self.missing
        difference = f"difference {self.difference:+.3g} {self.unit}"
        if self.interval is None:
            few = f"one {self.pair}" if self.runs == 1 else f"{self.runs} {self.pair}s"
            return f"{difference} in {few}, too few for an interval"
        interval = "{:+.3g} to {:+.3g}".format(*self.interval)
        return f"{difference}, {100 * CONFIDENCE:.0f} % interval {interval}, {self.runs} paired {self.pair}s"

    def __str__(self) -> str:
        return f"{self.text}: {self.verdict}" + (f" ({self.evidence})." if self.evidence else ".")


def compare(text: str, larger: Sequence[float], smaller: Sequence[float], unit: str, pair: str = "run") -> Claim:
    """The claim that the first numbers are larger than the second, pair by pair.

    It holds where Student's interval of the mean difference lies above zero, and does not where it lies below.
    """
    differences = np.asarray(larger, float) - np.asarray(smaller, float)
    mean, n = float(differences.mean()), len(differences)
    if n < FEWEST_RUNS:
        return Claim(text, Verdict.OPEN, mean, None, n, unit, pair)
    error = float(differences.std(ddof=1)) / n**0.5
    low, high = map(float, stats.t.interval(CONFIDENCE, n - 1, mean, error) if error > 0 else (mean, mean))
    verdict = Verdict.HOLDS if low > 0 else Verdict.FAILS if high < 0 else Verdict.OPEN
    return Claim(text, verdict, mean, (low, high), n, unit, pair)


def count_verdicts(claims: Iterable[Claim]) -> dict[Verdict, int]:
    """How many of the claims have each verdict."""
    found = Counter(claim.verdict for claim in claims)
    return {verdict: found[verdict] for verdict in Verdict}


def conclude(counts: Mapping[Verdict, int]) -> str:
    """The counts of all verdicts as one sentence."""
    holds, fails, undecided = (counts[verdict] for verdict in Verdict)
    total = holds + fails + undecided
    if not total:
        return "No claim of the thesis was tested."
    claims = "1 claim" if total == 1 else f"{total} claims"
    return (
        f"Of {claims} tested, {holds} {'holds' if holds == 1 else 'hold'}, "
        f"{fails} {'does' if fails == 1 else 'do'} not hold, and {undecided} cannot be told."
    )
