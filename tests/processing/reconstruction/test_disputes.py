"""Views that a single pair holds, which another one contradicts."""

import pytest

from orbitscan.processing.reconstruction.disputes import find_disputed

CHAIN = [(1, 0), (2, 1), (3, 2)]


@pytest.mark.parametrize(
    ("holding", "contradicting", "disputed"),
    [
        (CHAIN, [], set()),
        (CHAIN, [(3, 0)], {1, 2, 3}),  # any of the three may be wrong, or the fourth
        (CHAIN, [(3, 1)], {2, 3}),
        (CHAIN, [(2, 1)], {2, 3}),  # a pair found twice, differently
        ([*CHAIN, (3, 0)], [(2, 0)], set()),  # two paths lead everywhere: it is outvoted
        ([*CHAIN, (2, 0)], [(3, 0)], {3}),  # only the last one hangs on a single pair
        ([*CHAIN, (1, 0), (2, 1)], [(2, 0)], set()),  # pairs found twice, alike
        (CHAIN, [(9, 0), (9, 8)], set()),  # views that nothing holds are not ok anyway
        ([], [(1, 0)], set()),
    ],
)
def test_a_view_is_in_dispute_where_one_pair_speaks_for_it_and_one_against(holding, contradicting, disputed):
    assert find_disputed(holding, contradicting, 0) == disputed
    swapped = [[(b, a) for a, b in pairs] for pairs in (holding, contradicting)]
    assert find_disputed(*swapped, 0) == disputed


def test_the_origin_may_be_any_view():
    assert find_disputed(CHAIN, [(1, 0)], 3) == {0}
