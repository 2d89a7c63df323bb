"""Correspondences: descriptor pairs closer than a threshold (thesis 4.2)."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from threadpoolctl import ThreadpoolController


@dataclass(frozen=True)
class MatchSettings:
    """What counts as a match; no value is in the thesis."""

    max_distance: float = 0.9  # between unit descriptors, 0 to 2


def match(source: np.ndarray, target: np.ndarray, settings: MatchSettings) -> np.ndarray:
    """Index pairs (M, 2) int: each source descriptor (K, D) and the nearest target descriptor (L, D), nearest first.

    Only pairs closer than the threshold; rows of NaN match nothing. Exhaustive, as a matrix product: in 352 dimensions
    a kd-tree visits nearly every leaf.
    """
    source_valid = np.flatnonzero(np.isfinite(source[:, 0]))
    target_valid = np.flatnonzero(np.isfinite(target[:, 0]))
    if not len(source_valid) or not len(target_valid):
        return np.empty((0, 2), np.int64)
    with _blas().limit(limits=1, user_api="blas"):  # the sums' order may not depend on the number of threads
        cosine = source[source_valid] @ target[target_valid].T
    nearest = cosine.argmax(axis=1)
    distance = np.sqrt(np.maximum(0.0, 2.0 - 2.0 * cosine[np.arange(len(nearest)), nearest]))
    order = np.argsort(distance, kind="stable")
    order = order[distance[order] < settings.max_distance]
    return np.stack([source_valid[order], target_valid[nearest[order]]], axis=1)


@cache
def _blas() -> ThreadpoolController:
    return ThreadpoolController()
