"""Jacobi's eigenvectors against LAPACK's."""

import numpy as np
import pytest

from orbitscan.processing.kernels.eigen import symmetric_eigen


@pytest.mark.parametrize("eigenvalues", [(1, 2, 3), (1e-12, 1e-6, 1), (1, 1, 2), (0, 0, 0), (2, 2, 2), (-3, 0, 5)])
def test_eigenvalues_and_vectors(eigenvalues):
    rng = np.random.default_rng(7)
    Q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    A = Q @ np.diag(np.array(eigenvalues, dtype=float)) @ Q.T
    A = (A + A.T) / 2
    vectors = np.empty((3, 3))
    found = symmetric_eigen(A.copy(), vectors)
    assert np.allclose(found, np.linalg.eigvalsh(A), atol=1e-14 * max(1, *np.abs(eigenvalues)))
    assert np.allclose(vectors.T @ vectors, np.eye(3), atol=1e-12)
    assert np.allclose(A @ vectors, vectors * np.array(found), atol=1e-12)
