"""From logits to probabilities that mean something, and to a score that tells the known from the unknown.

The voxel grid loses the size of a thing, so its metric radius comes in here: log r is taken as Gaussian within a
category and as uniform otherwise, and the log ratio of the two is added to the category's logit, in training already.
The open-set score is the free energy of these joint logits, log sum exp (Liu et al., NeurIPS 2020): low where no
category explains both shape and size.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import log_softmax, logsumexp

from orbitscan.processing.classification.checkpoint import Calibration

KEPT = 0.95  # of known validation views
LEAST_DEVIATION = 0.35  # of log r: a third, however alike the instances are
SIZE_RANGE = np.log(1000)  # of log r, where nothing is known of a thing: 5 mm to 5 m, say
FUSED_VIEWS = 6  # that a session's threshold is set for
DRAWS = 400  # of so many views each
_RADII = 1e-9, 1e9  # [m] whose logarithm is taken; a view of one point, or of garbage, is outside


def joint_logits(logits: np.ndarray, radii: np.ndarray, calibration: Calibration) -> np.ndarray:
    """Logits (V, C) of shape and size together, from those of the shape (V, C) and the radii (V,) [m]."""
    if not calibration.size_means:
        return logits
    means, deviations = np.array(calibration.size_means), np.array(calibration.size_deviations)
    standard = (_log(radii)[:, None] - means) / deviations
    return logits - standard**2 / 2 - np.log(deviations * np.sqrt(2 * np.pi)) + np.log(SIZE_RANGE)


def log_probabilities(joint: np.ndarray, calibration: Calibration) -> np.ndarray:
    """Calibrated log probabilities (V, C) from joint logits (V, C)."""
    return log_softmax(joint / calibration.temperature, axis=1)


def open_set_scores(joint: np.ndarray) -> np.ndarray:
    """How well the categories explain each view (V,), from joint logits (V, C): higher is more surely known."""
    return logsumexp(joint, axis=1)


def measure_sizes(radii: np.ndarray, categories: np.ndarray, count: int) -> Calibration:
    """A calibration by size alone: mean and standard deviation of log r [m] of each of `count` categories."""
    logs = [_log(radii[categories == c]) for c in range(count)]
    deviations = tuple(max(float(np.std(log)), LEAST_DEVIATION) for log in logs)
    return Calibration(size_means=tuple(float(np.mean(log)) for log in logs), size_deviations=deviations)


def calibrate(
    logits: np.ndarray,
    radii: np.ndarray,
    categories: np.ndarray,
    sessions: np.ndarray,
    by_size: Calibration | None = None,
    seed: int = 0,
) -> Calibration:
    """A temperature (Guo et al., ICML 2017), and thresholds that keep KEPT of the known validation views and sessions.

    Logits (V, C), radii (V,) [m], true categories (V,) and recordings (V,) of validation views.
    """
    by_size = by_size or Calibration()
    joint = joint_logits(logits, radii, by_size)
    rows = np.arange(len(joint))

    def loss(log_temperature: float) -> float:
        return -float(log_softmax(joint / np.exp(log_temperature), axis=1)[rows, categories].mean())

    temperature = float(np.exp(minimize_scalar(loss, bounds=(np.log(0.2), np.log(20)), method="bounded").x))
    scores = open_set_scores(joint)
    rng = np.random.default_rng(seed)
    groups = [scores[sessions == name] for name in np.unique(sessions)]
    fused = [
        rng.choice(group, min(FUSED_VIEWS, len(group)), replace=False).mean()
        for group in (groups[i % len(groups)] for i in range(max(DRAWS, len(groups))))
    ]
    alone, together = _lowest_kept(scores), _lowest_kept(np.array(fused))
    return replace(by_size, temperature=temperature, threshold=alone, fused_threshold=together)


def _log(radii: np.ndarray) -> np.ndarray:
    return np.log(np.clip(radii, *_RADII))


def _lowest_kept(scores: np.ndarray) -> float:
    return float(np.quantile(scores, 1 - KEPT))
