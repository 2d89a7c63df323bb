"""The choice of pairs to register: in every band of angles, and round a closed circle."""

from itertools import pairwise

import numpy as np

from orbitscan.processing.reconstruction.partners import (
    choose_edges,
    choose_keyviews,
    choose_nearest,
    viewing_direction,
)
from tests.geometry import random_pose

BANDS = (10.0, 30.0, 50.0, 75.0)


def circle(n):
    angles = 2 * np.pi * np.arange(n) / n
    return {i: np.array([np.cos(a), np.sin(a), 0.0]) for i, a in enumerate(angles)}


def test_a_full_circle_gets_edges_in_every_band_and_a_closure():
    directions = circle(18)
    known = [(i, i - 1) for i in range(1, 18)]
    chosen = choose_edges(directions, known, BANDS)
    assert not {frozenset(pair) for pair in chosen} & {frozenset(pair) for pair in known}
    assert len({frozenset(pair) for pair in chosen}) == len(chosen)
    angles = [np.degrees(np.arccos(np.clip(directions[a] @ directions[b], -1, 1))) for a, b in chosen]
    assert max(angles) <= BANDS[-1]
    assert frozenset((17, 0)) in {frozenset(pair) for pair in chosen}
    for low, high in pairwise(BANDS):
        assert any(low < angle <= high for angle in angles)
    assert len(chosen) <= 6 * len(directions)


def test_half_a_circle_gets_no_closure():
    directions = {i: d for i, d in circle(18).items() if i < 9}
    chosen = choose_edges(directions, [], BANDS)
    assert chosen
    assert max(a - b for a, b in chosen) < 5
    assert choose_edges({0: directions[0]}, [], BANDS) == []


def test_the_viewing_direction_points_from_the_object_to_the_sensor():
    T = random_pose(np.random.default_rng(0))
    seen = viewing_direction(T, np.array([0, 0, 2.0]), np.zeros(3))
    assert np.allclose(seen, -T[:3, 2])
    assert np.allclose(viewing_direction(T, np.array([0, 0, 2.0]), None), -T[:3, 2])
    assert np.allclose(viewing_direction(T, np.array([2.0, 0, 0]), np.zeros(3)), -T[:3, 0])


def test_keyviews_are_spread_over_a_dense_circle_and_all_others_are_near_one():
    directions = circle(250)
    keyviews = choose_keyviews(directions, 10)
    assert 24 <= len(keyviews) <= 36
    pairs = choose_nearest(directions, keyviews, [(1, 0)])
    assert {source for source, _ in pairs} == set(directions) - set(keyviews) - {1}
    assert {target for _, target in pairs} <= set(keyviews)
    angles = [np.degrees(np.arccos(directions[a] @ directions[b])) for a, b in pairs]
    assert max(angles) <= 10


def test_every_view_of_a_coarse_circle_is_a_keyview():
    directions = circle(18)
    assert choose_keyviews(directions, 10) == list(directions)
    assert choose_nearest(directions, list(directions), []) == []
