"""Table 5.2: the formula by hand, the base that the thesis's numbers have, and a text that follows the numbers."""

import numpy as np
import pytest

from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import write
from orbitscan.processing.reproduction.training import cross_entropy


def test_the_formula():
    probabilities = np.array([[0.25, 0.75], [0.5, 0.5], [1 - 1e-9, 1e-9]])
    found = cross_entropy.cross_entropies(probabilities, np.array([0, 1, 0]))
    np.testing.assert_allclose(found, [np.log(4), np.log(2), 0], atol=1e-8)


@pytest.mark.parametrize("base", [2, 3, 10])
def test_the_base_of_sums_in_other_logarithms_is_found(base):
    nats = (4.13516655, 1.65025991)
    printed = tuple(round(value / np.log(base), 6) for value in nats)
    low, high = cross_entropy.find_base(printed, tuple(round(value, 3) for value in nats))
    assert low <= base <= high
    assert high - low < 0.001 * base**2


def test_sums_that_no_one_base_explains():
    low, high = cross_entropy.find_base((3.5, 1.6), (4.135, 1.65))
    assert low > high


def test_the_rows_are_the_samples_and_their_sum(tmp_path):
    report = cross_entropy.work_example(Plan(tmp_path))
    for name in cross_entropy.PROBABILITIES:
        *samples, total = (row for row in report.rows if row["classifier"] == name)
        assert [row["sample"] for row in samples] == ["1", "2", "3"]
        assert total["cross_entropy_nats"] == pytest.approx(sum(row["cross_entropy_nats"] for row in samples))
        assert total["to_base_3"] == pytest.approx(total["cross_entropy_nats"] / np.log(3))
        assert total["right"] == f"{sum(row['right'] == 'yes' for row in samples)} of 3"
        assert all(row["thesis_prints"] is None for row in samples)
    assert all(path.stat().st_size for path in write(report, Plan(tmp_path), "reproduce"))


def test_the_text_says_that_the_example_is_ours_and_follows_the_numbers(tmp_path, monkeypatch):
    before = cross_entropy.work_example(Plan(tmp_path)).said
    assert "our own" in before[0]
    monkeypatch.setattr(cross_entropy, "PRINTED", (3.5, 1.6))
    after = cross_entropy.work_example(Plan(tmp_path)).said
    assert before[2] != after[2]
    assert "does not explain it" in after[2]
    assert "are not those it prints" in after[-1]


def test_accuracy_that_differs_is_said(tmp_path, monkeypatch):
    better = {"first": np.full((3, 3), 1 / 3), "second": np.eye(3)[cross_entropy.CLASSES] * 0.97 + 0.01}
    monkeypatch.setattr(cross_entropy, "PROBABILITIES", better)
    said = cross_entropy.work_example(Plan(tmp_path)).said
    assert "tells them apart too" in said[1]
    assert "are not the thesis's by its formula" in said[-1]
