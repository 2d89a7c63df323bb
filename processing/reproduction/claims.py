"""What the thesis claims, held against our runs: it holds, it does not, or it cannot be told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import stats

Verdict = Literal["holds", "does not hold", "cannot be told"]
FEWEST_RUNS = 3  # an interval over fewer tells nothing
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Claim:
    """A claim, and what the runs say of it."""

    text: str
    verdict: Verdict
    difference: float  # mean over the pairs of runs of what is claimed to be positive
    low: float  # of its confidence interval
    high: float
    runs: int
    unit: str

    def __str__(self) -> str:
        said = f"{self.text}: {self.verdict}"
        if np.isnan(self.low):
            few = "one run" if self.runs == 1 else f"{self.runs} runs"
            return f"{said} (difference {self.difference:+.3g} {self.unit} in {few}, too few for an interval)."
        return (
            f"{said} (difference {self.difference:+.3g} {self.unit}, {100 * CONFIDENCE:.0f} % interval "
            f"{self.low:+.3g} to {self.high:+.3g}, {self.runs} paired runs)."
        )


def compare(text: str, larger: Sequence[float], smaller: Sequence[float], unit: str) -> Claim:
    """Whether the first runs are larger than the second, pair by pair: Student's interval of the mean difference."""
    differences = np.asarray(larger, float) - np.asarray(smaller, float)
    mean, n = float(differences.mean()), len(differences)
    if n < FEWEST_RUNS:
        return Claim(text, "cannot be told", mean, np.nan, np.nan, n, unit)
    error = float(differences.std(ddof=1)) / n**0.5
    low, high = stats.t.interval(CONFIDENCE, n - 1, mean, error) if error > 0 else (mean, mean)
    verdict: Verdict = "holds" if low > 0 else "does not hold" if high < 0 else "cannot be told"
    return Claim(text, verdict, mean, float(low), float(high), n, unit)
