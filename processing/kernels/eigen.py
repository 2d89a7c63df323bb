"""Eigenvalues and eigenvectors of a symmetric 3x3 matrix inside numba kernels."""

import numpy as np

from orbitscan.recorder.kernels import kernel

_SWEEPS = 12  # Jacobi's method converges quadratically; four or five are usual
_NEGLIGIBLE = 1e-17  # off the diagonal, as a share of the trace


@kernel
def symmetric_eigen(A: np.ndarray, vectors: np.ndarray) -> tuple[float, float, float]:
    """Return the eigenvalues of A (3, 3), ascending, and fill the columns of vectors; A is overwritten.

    Jacobi's cyclic rotations: exact to rounding also for tiny and repeated eigenvalues, where the closed form is not.
    """
    for i in range(3):
        for j in range(3):
            vectors[i, j] = 1.0 if i == j else 0.0
    for _ in range(_SWEEPS):
        off = abs(A[0, 1]) + abs(A[0, 2]) + abs(A[1, 2])
        if off <= _NEGLIGIBLE * (abs(A[0, 0]) + abs(A[1, 1]) + abs(A[2, 2])):
            break
        for p in range(2):
            for q in range(p + 1, 3):
                if A[p, q] == 0.0:
                    continue
                theta = (A[q, q] - A[p, p]) / (2.0 * A[p, q])
                t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
                if theta < 0.0:
                    t = -t
                c = 1.0 / np.sqrt(t * t + 1.0)
                s = t * c
                for k in range(3):
                    akp, akq = A[k, p], A[k, q]
                    A[k, p] = c * akp - s * akq
                    A[k, q] = s * akp + c * akq
                for k in range(3):
                    apk, aqk = A[p, k], A[q, k]
                    A[p, k] = c * apk - s * aqk
                    A[q, k] = s * apk + c * aqk
                A[p, q] = 0.0
                A[q, p] = 0.0
                for k in range(3):
                    vkp, vkq = vectors[k, p], vectors[k, q]
                    vectors[k, p] = c * vkp - s * vkq
                    vectors[k, q] = s * vkp + c * vkq
    for i in range(2):  # ascending
        for j in range(2 - i):
            if A[j, j] > A[j + 1, j + 1]:
                A[j, j], A[j + 1, j + 1] = A[j + 1, j + 1], A[j, j]
                for k in range(3):
                    vectors[k, j], vectors[k, j + 1] = vectors[k, j + 1], vectors[k, j]
    return A[0, 0], A[1, 1], A[2, 2]
