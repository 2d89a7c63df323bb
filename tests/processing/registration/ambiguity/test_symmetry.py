"""Groups of turns: what symmetries lead to, which are the same, and what a turn is called."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbitscan.processing.registration.ambiguity.symmetry import expand, is_among, is_turn, join, name_turn
from orbitscan.processing.results.estimates import Freedom, Symmetry
from orbitscan.recorder import poses
from tests.geometry import random_pose

X, Y, Z = np.eye(3)
POINT = np.array([0.1, -0.2, 1.0])


@given(st.integers(2, 36))
@settings(max_examples=15)
def test_a_symmetry_of_order_n_leads_to_n_poses(order):
    found = expand([Symmetry(Z, POINT, order)])
    assert len(found) == order
    assert all(np.allclose(poses.transform(D, POINT[None]), POINT) for D in found)


@pytest.mark.parametrize(("symmetries", "size"), [([(Z, 2), (X, 2)], 4), ([(Z, 4), (X, 2)], 8), ([(Z, 4), (X, 4)], 24)])
def test_two_axes_lead_to_a_whole_group(symmetries, size):
    """A box, a square prism, a cube."""
    group = expand([Symmetry(axis, POINT, order) for axis, order in symmetries])
    assert len(group) == size
    for D in group:
        inverse = poses.invert(D)
        assert any(np.allclose(inverse, other, atol=1e-9) for other in group)


def test_a_symmetry_is_the_same_in_another_frame():
    symmetry, T = Symmetry(Z, POINT, 5), random_pose(np.random.default_rng(0))
    moved = symmetry.moved(T)
    for here, there in zip(symmetry.turns(), moved.turns(), strict=True):
        assert np.allclose(T @ here @ poses.invert(T), there)


def test_a_higher_order_accounts_for_a_lower_one_about_the_same_axis():
    six, three, aside = Symmetry(Z, POINT, 6), Symmetry(-Z, POINT, 3), Symmetry(Z, POINT + 0.1 * X, 3)
    assert is_among([six], three, 0.3)
    assert not is_among([three], six, 0.3)
    assert not is_among([six], aside, 0.3)
    assert join([three], [six], 0.3) == [six]
    assert join([six], [three, aside], 0.3) == [six, aside]
    assert is_turn([Freedom("turn", Z, POINT)], three, 0.3)
    assert not is_turn([Freedom("shift", Z, POINT)], three, 0.3)


def repeats(order, refuted=None, worse=0.5):
    """What a solid with so many sides says of a turn about z."""

    def worse_by(D):
        angle = np.degrees(poses.twist(D[:3, :3], Z))
        off = abs((angle + 180 / order) % (360 / order) - 180 / order)
        return worse if off < 1 and (refuted is None or abs(abs(angle) - refuted) > 1) else None

    return worse_by


@pytest.mark.parametrize(("order", "turn"), [(3, 120), (6, 60), (6, 120), (12, 90), (18, 20), (24, 180)])
def test_a_turn_is_named_by_the_highest_order_that_stands(order, turn):
    D = poses.turn_about(Z, POINT, np.radians(turn))
    found = name_turn(D, POINT + 0.3 * Z, 0.01, repeats(order))
    assert isinstance(found, Symmetry)
    assert found.order == order
    assert np.allclose(found.axis, Z)
    assert np.allclose(np.cross(found.point - POINT, Z), 0, atol=1e-9)


@pytest.mark.parametrize(("refuted_from", "order"), [(2.0, 12), (np.inf, None)])
def test_an_order_that_explains_nearly_as_well_is_not_named_in_place_of_a_better_one(refuted_from, order):
    """The turns of thirteen sides lie near those of twelve: noise may hide the difference, but twelve are better."""

    def worse_by(D):
        turn = np.degrees(poses.twist(D[:3, :3], Z)) % 30
        off = min(turn, 30 - turn)  # degrees from a turn of twelve sides
        return None if off / 6 > refuted_from else 0.2 + off / 6

    found = name_turn(poses.turn_about(Z, POINT, np.radians(30)), POINT, 0.01, worse_by)
    assert isinstance(found, Freedom if order is None else Symmetry)
    assert getattr(found, "order", None) == order


def test_where_any_turn_stands_it_is_free():
    D = poses.turn_about(Z, POINT, np.radians(50))
    assert isinstance(name_turn(D, POINT, 0.01, lambda _: 0.0), Freedom)


def test_what_is_no_symmetry_is_not_named():
    turned = poses.turn_about(Z, POINT, np.radians(60))
    assert name_turn(turned, POINT, 0.01, repeats(6, refuted=120)) is None  # one of its turns is refuted
    assert name_turn(turned, POINT, 0.01, repeats(6, worse=6.0)) is None  # none is, but all explain badly
    assert name_turn(turned, POINT, 0.01, lambda _: np.nan) is None  # nothing tells
    assert name_turn(poses.make(np.eye(3), 0.1 * X), POINT, 0.01, repeats(6)) is None  # no turn
    assert name_turn(poses.make(np.eye(3), 0.1 * Z) @ turned, POINT, 0.01, repeats(6)) is None  # a screw
