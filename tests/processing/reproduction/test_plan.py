"""A plan says how large a reproduction is, and refuses what cannot be."""

from pathlib import Path

import pytest

from orbitscan.processing.reproduction.plan import Plan
from orbitscan.recorder.exceptions import InvalidOption


@pytest.mark.parametrize(("fraction", "every"), [(1.0, 1), (0.2, 5), (0.02, 50), (0.3, 3), (0.9, 1)])
def test_a_fraction_is_each_so_many_th_view(fraction, every):
    assert Plan(Path(), fraction=fraction).every == every


@pytest.mark.parametrize("change", [{"fraction": 0.0}, {"fraction": 1.5}, {"fraction": float("nan")}, {"runs": 0}])
def test_what_cannot_be_is_refused(change):
    with pytest.raises(InvalidOption, match=r"^(fraction|runs)="):
        Plan(Path(), **change)
