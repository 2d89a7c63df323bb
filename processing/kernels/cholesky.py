"""Small symmetric linear systems inside numba kernels."""

import numpy as np

from orbitscan.recorder.kernels import kernel

_NEGLIGIBLE = 1e-14  # absolute: callers scale A so that what counts is far above it


@kernel
def solve(A: np.ndarray, b: np.ndarray) -> bool:
    """Overwrite b (n,) by the solution x of A x = b and the lower triangle of A (n, n) by its Cholesky factor.

    False where A is not positive definite; b is then of no use.
    """
    n = len(b)
    for i in range(n):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i > j:
                A[i, j] = total / A[j, j]
            elif total > _NEGLIGIBLE:
                A[i, i] = np.sqrt(total)
            else:
                return False
    for i in range(n):
        for k in range(i):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            b[i] -= A[k, i] * b[k]
        b[i] /= A[i, i]
    return True
