"""A cloud's facts on clouds whose facts are known."""

import numpy as np
import pytest

from orbitscan.recorder import cloud


def grid(step=0.002, sides=(0.2, 0.1), z=0.7):
    x, y = np.meshgrid(np.arange(0, sides[0], step), np.arange(0, sides[1], step))
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1).astype(np.float32)


def test_points_that_are_not_finite_go_with_their_colors():
    points = np.array([[1, 2, 3], [np.nan, 0, 0], [0, np.inf, 0], [4, 5, 6], [0, 0, -np.inf]])
    colors = np.arange(15, dtype=np.uint8).reshape(5, 3)
    kept, kept_colors = cloud.finite(points, colors)
    np.testing.assert_array_equal(kept, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(kept_colors, colors[[0, 3]])
    assert kept.dtype == np.float32
    assert kept.flags.c_contiguous
    assert cloud.finite(points)[1] is None


def test_a_grid_measures_what_it_measures():
    facts = cloud.measure(grid())
    assert facts.points == 5000
    assert facts.resolution == pytest.approx(0.002, rel=1e-3)
    assert facts.extent == pytest.approx((0.198, 0.098, 0), abs=0.004)
    assert facts.diameter == pytest.approx(np.hypot(0.198, 0.098), abs=0.004)
    assert facts.distance == pytest.approx(np.linalg.norm([0.099, 0.049, 0.7]), rel=1e-3)
    assert facts.noise == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize("sigma", [0.0005, 0.002])
def test_the_noise_is_found_and_curvature_is_none(sigma):
    rng = np.random.default_rng(0)
    points = grid()
    points[:, 2] += 2 * (points[:, 0] - 0.1) ** 2 + rng.normal(scale=sigma, size=len(points))
    assert cloud.measure(points).noise == pytest.approx(sigma, rel=0.25)


def test_a_few_points_far_away_do_not_make_an_object_large():
    points = grid()
    points[:10] += 50
    assert cloud.measure(points).diameter < 0.23


def test_doubled_points_do_not_make_the_resolution_zero():
    assert cloud.measure(np.repeat(grid(), 2, axis=0)).resolution == pytest.approx(0.002, rel=1e-3)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 10, 33])
def test_few_points_are_measured_without_a_warning(n):
    facts = cloud.measure(grid()[:n])
    assert facts.points == n
    assert np.isfinite([facts.resolution, facts.diameter, facts.distance, facts.noise, *facts.extent]).all()


def test_all_points_in_one_place():
    facts = cloud.measure(np.ones((50, 3)))
    assert (facts.resolution, facts.diameter, facts.noise) == (0, 0, 0)
