"""Probabilities, sizes and thresholds by their formulas."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import log_softmax
from scipy.stats import norm

from orbitscan.processing.classification.calibration import (
    LEAST_DEVIATION,
    SIZE_RANGE,
    calibrate,
    joint_logits,
    log_probabilities,
    measure_sizes,
    open_set_scores,
)
from orbitscan.processing.classification.checkpoint import Calibration

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
    found = measure_sizes(radii, np.repeat([0, 1], 500), 2)
    np.testing.assert_allclose(found.size_means, [-3, 0], atol=0.1)
    assert found.size_deviations[0] == LEAST_DEVIATION
    assert found.size_deviations[1] == pytest.approx(0.8, abs=0.1)


@pytest.fixture(scope="module")
def overconfident():
    """Logits drawn so that their softmax is right, three times as large, of 30 recordings."""
    rng = np.random.default_rng(0)
    logits = rng.normal(size=(6000, 4)) * 2
    categories = np.array([rng.choice(4, p=np.exp(row)) for row in log_softmax(logits, axis=1)])
    return 3 * logits, categories, np.arange(6000) // 200


def test_the_temperature_undoes_overconfidence(overconfident):
    logits, categories, sessions = overconfident
    found = calibrate(logits, np.ones(len(logits)), categories, sessions)
    assert found.temperature == pytest.approx(3, rel=0.1)

    def loss(temperature):
        logs = log_probabilities(logits, Calibration(temperature=temperature))
        return -logs[np.arange(len(logs)), categories].mean()

    assert loss(found.temperature) < min(loss(0.99 * found.temperature), loss(1.01 * found.temperature))


def test_the_thresholds_keep_95_percent(overconfident):
    logits, categories, sessions = overconfident
    found = calibrate(logits, np.ones(len(logits)), categories, sessions)
    scores = open_set_scores(logits)
    assert (scores >= found.threshold).mean() == pytest.approx(0.95, abs=0.001)
    assert found.threshold < found.fused_threshold < np.mean(scores)
    again = calibrate(logits, np.ones(len(logits)), categories, sessions)
    assert again == found


@pytest.mark.parametrize("scale", [0.5, 2.0, 8.0])
def test_the_temperature_is_the_scale_of_the_logits(overconfident, scale):
    logits, categories, sessions = overconfident
    right = logits / 3
    found = calibrate(scale * right, np.ones(len(logits)), categories, sessions)
    assert found.temperature == pytest.approx(scale, rel=0.1)
    as_it_was = calibrate(right, np.ones(len(logits)), categories, sessions)
    assert found.temperature == pytest.approx(scale * as_it_was.temperature, rel=1e-3)


def test_probabilities_are_the_softmax_of_shape_and_size_by_the_temperature():
    joint, found = np.array([[1.0, 3.0], [800.0, -800.0]]), replace(MUGS_AND_CARS, temperature=2.0)
    p = np.exp(log_probabilities(joint, found))
    np.testing.assert_allclose(p[0], np.exp([0.5, 1.5]) / np.exp([0.5, 1.5]).sum())
    np.testing.assert_allclose(p[1], [1, 0])


def test_equal_shapes_are_told_apart_by_size_as_bayes_does():
    radii = np.array([0.06, 0.3, 2.0])
    p = np.exp(log_probabilities(joint_logits(np.zeros((3, 2)), radii, MUGS_AND_CARS), Calibration()))
    densities = np.stack([norm.pdf(np.log(radii), np.log(0.06), 0.35), norm.pdf(np.log(radii), np.log(2.0), 0.4)], 1)
    np.testing.assert_allclose(p, densities / densities.sum(axis=1, keepdims=True))
    assert p[0, 0] > 0.999
    assert p[2, 1] > 0.999


def test_the_score_falls_the_farther_a_size_is_from_all(overconfident):
    radii = 0.06 * np.array([1, 2, 4, 8])
    mugs = Calibration(size_means=(np.log(0.06),) * 4, size_deviations=(0.35,) * 4)
    scores = open_set_scores(joint_logits(np.tile(overconfident[0][0], (4, 1)), radii, mugs))
    assert (np.diff(scores) < 0).all()
    np.testing.assert_allclose(scores - scores[0], -((np.log(radii / 0.06) / 0.35) ** 2) / 2)


def test_a_size_that_has_no_logarithm_is_far_from_all_and_finite():
    joint = joint_logits(np.zeros((3, 2)), np.array([0.0, np.inf, 0.06]), MUGS_AND_CARS)
    assert np.isfinite(joint).all()
    assert (open_set_scores(joint)[:2] < -100).all()
    found = measure_sizes(np.array([0.0, 0.06, 0.06]), np.array([0, 0, 1]), 2)
    assert np.isfinite([*found.size_means, *found.size_deviations]).all()


def test_the_thresholds_count_the_size_in(overconfident):
    logits, categories, sessions = overconfident
    radii = np.exp(np.random.default_rng(1).normal(-2, 0.5, len(logits)))
    sizes = measure_sizes(radii, categories, 4)
    found = calibrate(logits, radii, categories, sessions, sizes)
    assert (found.size_means, found.size_deviations) == (sizes.size_means, sizes.size_deviations)
    scores = open_set_scores(joint_logits(logits, radii, found))
    assert (scores >= found.threshold).mean() == pytest.approx(0.95, abs=0.001)
    rng = np.random.default_rng(2)
    fused = [rng.choice(scores[sessions == i % 30], 6, replace=False).mean() for i in range(3000)]
    assert (np.array(fused) >= found.fused_threshold).mean() == pytest.approx(0.95, abs=0.03)


def test_one_recording_of_one_view_is_enough():
    found = calibrate(np.array([[2.0, 0.0]]), np.ones(1), np.array([0]), np.array(["a"]))
    assert found.threshold == found.fused_threshold == pytest.approx(np.log(np.exp(2) + 1))
