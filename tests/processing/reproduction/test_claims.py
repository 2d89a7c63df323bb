"""A claim holds, does not hold or cannot be told, by the interval of the paired differences."""

import numpy as np
import pytest
from scipy import stats

from orbitscan.processing.reproduction.claims import Claim, Verdict, compare, conclude, count_verdicts


def test_the_interval_is_that_of_students_paired_test():
    rng = np.random.default_rng(3)
    larger, smaller = rng.normal(0.4, 1, 12), rng.normal(0, 1, 12)
    claim = compare("a is larger", larger, smaller, "points")
    expected = stats.ttest_rel(larger, smaller).confidence_interval(0.95)
    assert claim.interval == pytest.approx((expected.low, expected.high))
    assert claim.difference == pytest.approx((larger - smaller).mean())


@pytest.mark.parametrize(("shift", "verdict"), [(2.0, "holds"), (-2.0, "does not hold"), (0.0, "cannot be told")])
def test_the_verdict_follows_the_interval(shift, verdict):
    noise = np.array([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    claim = compare("a is larger", noise + shift, np.zeros(6), "points")
    assert claim.verdict == verdict
    assert str(claim).startswith(f"a is larger: {verdict} (difference {shift:+.3g} points, 95 % interval ")


def test_pairs_count_not_the_spread_over_runs():
    level = np.array([10.0, 50.0, 90.0, 30.0])
    assert compare("a is larger", level + 1, level, "points").verdict == "holds"


def test_few_runs_tell_nothing():
    claim = compare("a is larger", [5, 6], [1, 1], "points")
    assert claim.verdict == "cannot be told"
    assert str(claim).endswith("(difference +4.5 points in 2 runs, too few for an interval).")


def test_without_a_pair_the_reason_is_the_evidence():
    claim = Claim("a is larger", Verdict.OPEN, missing="nothing was measured")
    assert str(claim) == "a is larger: cannot be told (nothing was measured)."


def test_verdicts_are_counted_and_told():
    verdicts = (Verdict.HOLDS, Verdict.HOLDS, Verdict.FAILS)
    counts = count_verdicts(Claim("a", verdict) for verdict in verdicts)
    assert counts == {"holds": 2, "does not hold": 1, "cannot be told": 0}
    assert conclude(counts) == "Of 3 claims tested, 2 hold, 1 does not hold, and 0 cannot be told."
    assert "No claim" in conclude(count_verdicts([]))
