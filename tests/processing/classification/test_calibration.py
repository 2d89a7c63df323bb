"""Probabilities, sizes and thresholds by their formulas."""

import numpy as np
import pytest
from scipy.special import log_softmax
from scipy.stats import norm

from processing.classification.calibration import (
    LEAST_DEVIATION,
    SIZE_RANGE,
    calibrate,
    joint_logits,
    log_probabilities,
    measure_sizes,
    open_set_scores,
)
from processing.classification.checkpoint import Calibration

MUGS_AND_CARS = Calibration(size_means=(np.log(0.06), np.log(2.0)), size_deviations=(0.35, 0.4))


def test_a_size_adds_the_log_ratio_of_its_densities():
    logits, radii = np.array([[1.0, 2.0], [0.0, 0.0]]), np.array([0.07, 3.0])
    expected = logits + [
        [norm.logpdf(np.log(r), np.log(0.06), 0.35), norm.logpdf(np.log(r), np.log(2.0), 0.4)] for r in radii
    ]
    np.testing.assert_allclose(joint_logits(logits, radii, MUGS_AND_CARS), expected + np.log(SIZE_RANGE))
    np.testing.assert_array_equal(joint_logits(logits, radii, Calibration()), logits)


def test_a_mug_of_three_metres_is_no_mug():
    joint = joint_logits(np.array([[5.0, -5.0]] * 2), np.array([0.06, 3.0]), MUGS_AND_CARS)
    assert open_set_scores(joint)[0] > 5
    assert open_set_scores(joint)[1] < 0


def test_sizes_are_means_and_deviations_of_the_logarithm_and_never_too_sure():
    rng = np.random.default_rng(0)
    radii = np.exp(np.concatenate([rng.normal(-3, 0.01, 500), rng.normal(0, 0.8, 500)]))
    means, deviations = measure_sizes(radii, np.repeat([0, 1], 500), 2)
    np.testing.assert_allclose(means, [-3, 0], atol=0.1)
    assert deviations[0] == LEAST_DEVIATION
    assert deviations[1] == pytest.approx(0.8, abs=0.1)


@pytest.fixture(scope="module")
def overconfident():
    """Logits drawn so that their softmax is right, three times as large, of 30 recordings."""
    rng = np.random.default_rng(0)
    logits = rng.normal(size=(6000, 4)) * 2
    categories = np.array([rng.choice(4, p=np.exp(row)) for row in log_softmax(logits, axis=1)])
    return 3 * logits, categories, np.arange(6000) // 200


def test_the_temperature_undoes_overconfidence(overconfident):
    logits, categories, sessions = overconfident
    found = calibrate(logits, np.ones(len(logits)), categories, sessions, ((), ()))
    assert found.temperature == pytest.approx(3, rel=0.1)

    def loss(temperature):
        logs = log_probabilities(logits, Calibration(temperature=temperature))
        return -logs[np.arange(len(logs)), categories].mean()

    assert loss(found.temperature) < min(loss(0.9 * found.temperature), loss(1.1 * found.temperature))


def test_the_thresholds_keep_95_percent(overconfident):
    logits, categories, sessions = overconfident
    found = calibrate(logits, np.ones(len(logits)), categories, sessions, ((), ()))
    scores = open_set_scores(logits)
    assert (scores >= found.threshold).mean() == pytest.approx(0.95, abs=0.001)
    assert found.threshold < found.fused_threshold < np.mean(scores)
    again = calibrate(logits, np.ones(len(logits)), categories, sessions, ((), ()))
    assert again == found
