"""How well poses are known: more surface, less noise and more of it across the motion know them better."""

import math

import pytest

from orbitscan.processing.results.comparison.uncertainty import pair_deviation, scale_of_errors, view_deviations
from orbitscan.processing.results.estimates import Evidence, MethodResult, PairErrors, PairEstimate
from orbitscan.processing.results.folder import ROUNDING
from orbitscan.processing.results.status import Method, Status
from tests.processing.results.made import make_results

Q = 2.0


def pair(source=1, target=0, status=Status.OK, error_m=None, turned_deg=0.0, **evidence):
    """A pair whose observable error is known, or is not."""
    known = {"rmse_m": 1e-3, "overlap": 0.5, "observability": 0.1, "points": 4000}
    errors = PairErrors(None, None, turned_deg, error_m) if error_m is not None else PairErrors()
    return PairEstimate(source, target, None, status, 1.0, Evidence(**known | evidence), errors=errors)


def results(method, *pairs):
    return make_results(reconstruction={Method(method): MethodResult((), pairs)})


def test_a_deviation_is_the_residual_over_the_root_of_the_patches_that_hold_it():
    patches = 4000 * 0.5 / (math.pi * Q**2)
    assert pair_deviation(pair(), Q) == pytest.approx(1e-3 / math.sqrt(patches * 0.1))


@pytest.mark.parametrize(
    ("evidence", "ratio"), [({"rmse_m": 2e-3}, 2), ({"points": 16000}, 0.5), ({"observability": 0.025}, 2)]
)
def test_it_grows_with_the_residual_and_shrinks_with_what_holds_it(evidence, ratio):
    assert pair_deviation(pair(**evidence), Q) == pytest.approx(ratio * pair_deviation(pair(), Q))


def test_less_than_a_patch_counts_as_one_and_nothing_is_known_beyond_rounding():
    assert pair_deviation(pair(points=1), Q) == pytest.approx(1e-3 / math.sqrt(0.1))
    assert pair_deviation(pair(rmse_m=1e-15), Q) == ROUNDING


@pytest.mark.parametrize(
    "unknown", [{"status": Status.LOW_OVERLAP}, {"rmse_m": None}, {"overlap": 0.0}, {"observability": None}]
)
def test_a_pair_that_failed_or_says_nothing_has_none(unknown):
    assert pair_deviation(pair(**unknown), Q) is None
    assert view_deviations([pair(**unknown)], 0, Q) == {0: 0.0}


def test_squares_add_along_the_best_chain():
    sigma = pair_deviation(pair(), Q)
    chain = [pair(1, 0), pair(2, 1), pair(3, 2)]
    found = view_deviations(chain, 0, Q)
    assert [found[view] / sigma for view in range(4)] == pytest.approx([0, 1, math.sqrt(2), math.sqrt(3)])
    closed = view_deviations([*chain, pair(0, 3)], 0, Q)  # a loop: the last view is one pair away, either way round
    assert closed[3] == pytest.approx(sigma)
    weak = view_deviations([*chain, pair(0, 3, rmse_m=1.0)], 0, Q)  # which the strong chain beats
    assert weak[3] == pytest.approx(found[3])
    assert set(view_deviations([pair(1, 0), pair(3, 2)], 0, Q)) == {0, 1}


def test_the_measured_error_widens_it_and_never_narrows_it():
    sigma = pair_deviation(pair(), Q)

    def scale(*errors, method="pairwise"):
        return scale_of_errors(results(method, *(pair(error_m=error) for error in errors)), 0.1, Q)

    assert scale(None) == 1.0
    assert scale(0.1 * sigma) == 1.0
    assert scale(3 * sigma, 4 * sigma, 100 * sigma) == pytest.approx(4)  # the middle: one gross error is no noise
    assert scale(4 * sigma, method="icp") == 1.0  # which sigma does not describe


def test_a_turn_counts_by_what_it_moves_at_the_lever():
    sigma = pair_deviation(pair(), Q)
    turned = pair(error_m=0.0, turned_deg=math.degrees(5 * sigma / 0.1))
    assert scale_of_errors(results("refined", turned), 0.1, Q) == pytest.approx(5)
