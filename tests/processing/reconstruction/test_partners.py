"""The choice of pairs to register: in every band of angles, round a circle, and for views that nothing holds."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from orbitscan.processing.reconstruction.partners import (
    Partners,
    choose_edges,
    choose_keyviews,
    choose_nearest,
    viewing_direction,
)
from orbitscan.processing.reconstruction.pose_graph import GraphSettings
from orbitscan.processing.results.estimates import Freedom
from orbitscan.processing.results.status import Status
from tests.geometry import random_pose, scan
from tests.processing.scene import SETTINGS, Scene, edge

DIAMETER = 0.3
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


@pytest.fixture(scope="module")
def scene():
    """Five views, 20 degrees from one to the next."""
    return Scene(scan(n_views=5, step_deg=20))


@pytest.fixture
def partners(scene):
    return Partners(range(5), scene, SETTINGS.pair, GraphSettings(tries=3, weak_tries=2), DIAMETER)


def ask(partners, groups, core, status, freedom=None):
    """The pairs proposed, all of which come to nothing."""
    asked = []
    for source, target in partners.propose(groups, core):
        asked.append((source, target))
        freedoms = () if freedom is None else (freedom,)
        partners.learn(replace(edge(source, target, np.eye(4), freedoms=freedoms), status=status))
    return asked


def test_the_view_that_overlaps_most_is_asked_first_and_not_all(partners):
    asked = ask(partners, [[4]], [0, 1, 2, 3], Status.DIVERGED)
    assert asked[0] == (4, 3)
    assert len(asked) == 3
    assert ask(partners, [[4]], [0, 1, 2, 3], Status.DIVERGED) == []


def test_any_view_of_a_group_may_hold_it(partners):
    assert ask(partners, [[3, 4]], [2], Status.DIVERGED)[0] == (3, 2)


def test_a_view_that_leaves_the_same_open_twice_is_asked_no_more(partners):
    freedom = Freedom("turn", np.array([0, 1.0, 0]), np.zeros(3))
    partners.learn(replace(edge(4, 3, np.eye(4), freedoms=(freedom,)), status=Status.AMBIGUOUS))
    assert len(ask(partners, [[4]], [0, 1, 2], Status.AMBIGUOUS, freedom)) == 1
