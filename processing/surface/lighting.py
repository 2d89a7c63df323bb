"""What lamps do to colours: smooth functions of the normal, which are fitted and removed, and highlights, left out."""

from itertools import combinations_with_replacement

import numpy as np

TRACES = 0.06  # of a logarithm, that light leaves where it is not quite what is fitted: no more is taken for paint
_ROUNDS = 3
_OUTLYING = 3.0  # deviations of a residual that counts a quarter when a lamp is fitted
_HIGHLIGHT = 3.0  # deviations by which a highlight is brighter than the light about it
_LEAST_DEVIATION = 0.02  # of a logarithm, in that
_RIDGE = 1e-3  # of the weights: what few normals do not tell of a lamp is small
_MEDIAN = 0.4549  # of a squared standard normal deviate
_LEAST_USUAL = 0.1  # variances that are usual of a residual, at least


def light_basis(normals: np.ndarray) -> np.ndarray:
    """What diffuse light adds up of, (K, 18): unit normals' spherical harmonics of the orders 0, 1, 2 and 4.

    Light that falls on one side has no others, but for traces (Basri and Jacobs, Lambertian reflectance and linear
    subspaces, 2003).
    """
    even = [normals[:, list(factors)].prod(axis=1) for factors in combinations_with_replacement(range(3), 4)]
    return np.column_stack([normals, *even])


def remove_light(residuals: np.ndarray, variances: np.ndarray, light: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return residuals (K, C) of variances (K, C) without what lamps may add up of (K, L), and their weights (K, C).

    The weights are the inverses of variances, less for residuals that are unusual.
    """
    left, weights = residuals.copy(), 1 / variances
    for channel in range(residuals.shape[1] if len(left) else 0):
        for _ in range(_ROUNDS):
            left[:, channel] -= project(light, weights[:, channel], left[:, channel, None])[:, 0]
            squares = left[:, channel] ** 2 / variances[:, channel]
            usual = max(float(np.median(squares)) / _MEDIAN, _LEAST_USUAL)
            weights[:, channel] = 1 / variances[:, channel] / (1 + squares / (_OUTLYING**2 * usual)) ** 2
    return left, weights


def project(light: np.ndarray, weights: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """The parts of columns (K, C) that a least-squares fit of the light (K, L) accounts for, with weights (K,)."""
    if not len(light):
        return columns
    weighted = light * weights[:, None]
    N = weighted.T @ light
    N[np.diag_indices_from(N)] += _RIDGE * weights.sum() / len(N)
    return light @ np.linalg.solve(N, weighted.T @ columns)


def find_highlights(brightness: np.ndarray, variances: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Tell which surfels (S,) are clearly brighter than what is lit about them: a lamp may be mirrored there."""
    left = remove_light(brightness[:, None], variances[:, None], light)[0][:, 0]
    deviation = max(float(np.sqrt(np.median(left**2) / _MEDIAN)) if len(left) else 0.0, _LEAST_DEVIATION)
    return np.asarray(left > _HIGHLIGHT * deviation)
