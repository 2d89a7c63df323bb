"""Descriptor matching: the nearest within the threshold."""

import numpy as np
from scipy.spatial.distance import cdist

from orbitscan.processing.registration.matching import MatchSettings, match


def unit(rng, n):
    rows = rng.random((n, 352)).astype(np.float32)
    return rows / np.linalg.norm(rows, axis=1, keepdims=True)


def test_matches_are_the_nearest_below_the_threshold():
    rng = np.random.default_rng(0)
    source, target = unit(rng, 40), unit(rng, 60)
    distance = cdist(source, target)
    threshold = float(np.median(distance.min(axis=1)))
    found = match(source, target, MatchSettings(max_distance=threshold))
    expected = {(i, int(row.argmin())) for i, row in enumerate(distance) if row.min() < threshold}
    assert set(map(tuple, found.tolist())) == expected
    lengths = distance[found[:, 0], found[:, 1]]
    assert (np.diff(lengths) > -1e-6).all()


def test_invalid_descriptors_match_nothing():
    rng = np.random.default_rng(0)
    source = unit(rng, 5)
    target = source.copy()
    source[2] = np.nan
    target[3] = np.nan
    found = match(source, target, MatchSettings(max_distance=0.01))
    assert set(map(tuple, found.tolist())) == {(0, 0), (1, 1), (4, 4)}
    assert match(source[2:3], target, MatchSettings()).shape == (0, 2)
    assert match(np.empty((0, 352)), target, MatchSettings()).shape == (0, 2)
