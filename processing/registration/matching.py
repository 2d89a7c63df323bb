"""Correspondences: descriptor pairs closer than a threshold (thesis 4.2)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.kernels.blas import SingleThreaded
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.results.estimates import Correspondences, PairEstimate
from orbitscan.processing.results.status import Method

Matched = dict[PreparedView, Matches]  # the matches of one source view, by target


@dataclass(frozen=True)
class MatchSettings:
    """What counts as a match; no value is in the thesis."""

    max_distance: float = 0.9  # between unit descriptors, 0 to 2
    nearest: int = 1  # target descriptors that each source descriptor is matched to


def match(source: np.ndarray, target: np.ndarray, settings: MatchSettings) -> np.ndarray:
    """Pair the indices (M, 2) int of each source descriptor (K, D) and the target descriptors (L, D) nearest to it.

    Sorted by distance. Only pairs closer than the threshold; rows of NaN match nothing. Exhaustive, as a matrix
    product: in 352 dimensions a kd-tree visits nearly every leaf.
    """
    source_valid = np.flatnonzero(np.isfinite(source[:, 0]))
    target_valid = np.flatnonzero(np.isfinite(target[:, 0]))
    if not len(source_valid) or not len(target_valid):
        return np.empty((0, 2), np.int64)
    with SingleThreaded():  # the sums' order may not depend on the number of threads
        cosine = source[source_valid] @ target[target_valid].T
    if settings.nearest == 1:
        nearest = cosine.argmax(axis=1)[:, None]
    else:
        nearest = np.argsort(-cosine, axis=1, kind="stable")[:, : settings.nearest]
    rows = np.repeat(np.arange(len(cosine)), nearest.shape[1])
    columns = nearest.ravel()
    distance = np.sqrt(np.maximum(0.0, 2.0 - 2.0 * cosine[rows, columns]))
    order = np.argsort(distance, kind="stable")
    order = order[distance[order] < settings.max_distance]
    return np.stack([source_valid[rows[order]], target_valid[columns[order]]], axis=1)


def choose_correspondences(
    source: PreparedView, pairs: Mapping[Method, PairEstimate], matched: Matched
) -> Correspondences | None:
    """Return the matches behind the last of a view's pairs (by method, worst to best) that has any; None without any.

    Each keypoint is in its own view's frame.
    """
    targets = {target.view: target for target in matched}
    chosen = [targets[pair.target] for pair in pairs.values() if pair.target in targets]
    if not chosen:
        return None
    target, matches = chosen[-1], matched[chosen[-1]]
    rows, columns = matches.indices.T
    inlier = np.zeros(len(rows), bool) if matches.consensus is None else matches.consensus.inlier
    return Correspondences(source.view, target.view, source.keypoints[rows], target.keypoints[columns], inlier)
