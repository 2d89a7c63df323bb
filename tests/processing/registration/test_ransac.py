"""The closed-form fit and the adaptive RANSAC, by their properties."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbitscan.processing.registration.ransac import RansacSettings, estimate_pose, fit, trials_needed
from orbitscan.recorder import poses
from tests.geometry import random_pose


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6), st.integers(3, 40))
def test_fit_restores_a_rigid_motion(seed, n):
    rng = np.random.default_rng(seed)
    T, points = random_pose(rng), rng.normal(size=(n, 3))
    assert np.allclose(fit(points[None], poses.transform(T, points)[None])[0], T, atol=1e-6)


def test_fit_never_mirrors():
    rng = np.random.default_rng(0)
    flat = rng.normal(size=(200, 3, 3)) * [1, 1, 1e-9]
    found = fit(flat, flat * [1, 1, -1] + rng.normal(size=(200, 1, 3)))
    assert np.allclose(np.linalg.det(found[:, :3, :3]), 1)


def test_fit_is_the_least_squares_optimum():
    rng = np.random.default_rng(3)
    source, target = rng.normal(size=(2, 30, 3))
    best = fit(source[None], target[None])[0]
    cost = ((poses.transform(best, source) - target) ** 2).sum()
    for _ in range(200):
        other = random_pose(rng, angle=0.05, shift=0.05) @ best
        assert ((poses.transform(other, source) - target) ** 2).sum() >= cost


@pytest.mark.parametrize("outliers", [0.0, 0.5, 0.8])
def test_consensus_survives_outliers(outliers):
    rng = np.random.default_rng(1)
    T, source = random_pose(rng), rng.random((300, 3))
    target = poses.transform(T, source) + rng.normal(scale=0.002, size=(300, 3))
    wrong = rng.random(300) < outliers
    target[wrong] = rng.random((wrong.sum(), 3)) + 5
    found = estimate_pose(source, target, 0.01, RansacSettings(), np.random.default_rng(0))
    assert (found.inlier == ~wrong).mean() > 0.99
    assert np.allclose(found.T_target_source, T, atol=0.01)


def test_more_outliers_take_more_trials():
    counts = []
    for outliers in (0.2, 0.85):
        rng = np.random.default_rng(5)
        T, source = random_pose(rng), rng.random((400, 3))
        target = poses.transform(T, source)
        wrong = rng.random(400) < outliers
        target[wrong] += rng.random((wrong.sum(), 3))
        counts.append(estimate_pose(source, target, 0.005, RansacSettings(batch=20), rng).trials)
    assert counts[0] < counts[1]


def test_no_consensus_among_noise_or_too_few():
    rng = np.random.default_rng(2)
    how = RansacSettings(max_trials=2000)
    assert estimate_pose(rng.random((60, 3)), 9 * rng.random((60, 3)), 1e-3, how, rng) is None
    assert estimate_pose(np.empty((0, 3)), np.empty((0, 3)), 0.1, how, rng) is None


def test_trials_needed_is_the_formula():
    assert trials_needed(0.5, 0.99) == pytest.approx(np.log(0.01) / np.log(1 - 0.125))
    assert trials_needed(1.0, 0.99) == 1
    assert trials_needed(0.0, 0.99) == np.inf
