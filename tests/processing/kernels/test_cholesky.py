"""The kernel's solution of small symmetric systems is numpy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.processing.kernels.cholesky import solve


@given(st.integers(0, 10**6), st.integers(1, 8))
def test_the_solution_is_numpys(seed, n):
    rng = np.random.default_rng(seed)
    B, b = rng.normal(size=(n, n)), rng.normal(size=n)
    A = B @ B.T + 0.1 * np.eye(n)
    x, factor = b.copy(), A.copy()
    assert solve(factor, x)
    assert np.allclose(x, np.linalg.solve(A, b), rtol=1e-8, atol=1e-10)
    assert np.allclose(np.tril(factor), np.linalg.cholesky(A))


def test_only_the_lower_triangle_is_read():
    A = np.array([[4.0, np.nan], [1.0, 3.0]])
    x = np.array([1.0, 2.0])
    assert solve(A, x)
    assert np.allclose(x, np.linalg.solve([[4, 1], [1, 3]], [1, 2]))


@pytest.mark.parametrize(
    "A",
    [[[1.0, 2.0], [2.0, 1.0]], [[1.0, 1.0], [1.0, 1.0]], [[-1.0, 0.0], [0.0, 1.0]], [[0.0, 0.0], [0.0, 0.0]]],
    ids=["indefinite", "singular", "negative", "zero"],
)
def test_what_is_not_positive_definite_is_refused(A):
    assert not solve(np.array(A), np.ones(2))


def test_a_number_that_is_none_is_refused():
    assert not solve(np.array([[np.nan, 0.0], [0.0, 1.0]]), np.ones(2))
