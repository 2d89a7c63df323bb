"""The moments of a ball are numpy's."""

import numpy as np

from orbitscan.processing.kernels.grid import build
from orbitscan.processing.kernels.moments import moments_around


def test_sums_over_the_ball():
    points = np.random.default_rng(0).normal(size=(800, 3))
    grid = build(points, 0.6)
    first, second = np.empty(3), np.empty((3, 3))
    for i in range(0, 800, 37):
        count = moments_around(grid, i, 0.6, first, second)
        d = grid.points - grid.points[i]
        d = d[(d**2).sum(axis=1) < 0.36]
        assert count == len(d)
        assert np.allclose(first, d.sum(axis=0), atol=1e-12)
        assert np.allclose(second, d.T @ d, atol=1e-12)
