import numpy as np
import pytest

from orbitscan.recorder.objects.vessel import (
    coupe,
    fluted,
    hollow,
    inward,
    lathe,
    polygon,
    silhouette,
    superellipse,
)
from tests.recorder.test_objects import assert_closed_and_outward

WHITE, RED = (255, 255, 255), (255, 0, 0)


def area(outline):
    x, y = outline.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def test_a_silhouette_goes_through_its_radii_and_rounds_its_foot_off():
    wall = silhouette(0.1, (0.03, 0.05, 0.04), fillet=0.01, count=200)
    np.testing.assert_allclose(wall[-1], (0.04, 0.1))
    assert wall[np.abs(wall[:, 1] - 0.05).argmin(), 0] == pytest.approx(0.05, abs=1e-5)
    assert (np.diff(wall[:, 1]) > 0).all()
    assert wall[0, 1] == 0
    assert wall[3, 0] - wall[0, 0] == pytest.approx(0.01)


def test_a_coupe_is_straight_at_exponent_two_and_ends_at_its_radius_flare_and_all():
    wall = coupe(0.03, 0.08, 0.005, 0.065, 2)
    np.testing.assert_allclose((wall[:, 0] - 0.03) / 0.05, (wall[:, 1] - 0.005) / 0.06, atol=1e-12)
    np.testing.assert_allclose(coupe(0.03, 0.08, 0.005, 0.065, 1, flare=0.01)[-1], (0.08, 0.065))


def test_inward_keeps_its_distance():
    wall = coupe(0.03, 0.08, 0.005, 0.065, 2)
    distance = np.abs((inward(wall, 0.004) - wall[0]) @ (0.06, -0.05)) / np.hypot(0.06, 0.05)
    np.testing.assert_allclose(distance, 0.004)


def test_outlines_have_their_areas():
    assert area(superellipse(2)) == pytest.approx(np.pi, rel=1e-3)
    assert area(superellipse(40)) == pytest.approx(4, rel=0.02)
    assert area(superellipse(2, aspect=0.5)) == pytest.approx(np.pi / 2, rel=3e-3)
    assert area(polygon(6)) == pytest.approx(1.5 * np.sqrt(3))
    crests = np.linalg.norm(fluted(8, 0.1), axis=1)
    assert (crests.min(), crests.max()) == pytest.approx((0.9, 1))
    assert np.isclose(crests, 1).sum() == 8


def test_a_lathe_turns_a_square_into_a_circle():
    square = polygon(4)
    cone = lathe(np.array([(0, 0), (1, 0), (1, 2), (0, 2)]), square)
    morphed = lathe(np.array([(0, 0), (1, 0), (1, 2), (0, 2)]), square, np.array([1, 1, 0, 0]))
    assert_closed_and_outward(morphed)
    assert cone.volume == pytest.approx(4)
    assert 4 < morphed.volume < 2 * np.pi
    top = morphed.vertices[morphed.vertices[:, 2] == 2]
    assert np.linalg.norm(top[:-1, :2], axis=1) == pytest.approx(1)


@pytest.mark.parametrize(("outline", "exponent"), [(None, 2), (superellipse(4), 4)])
def test_a_hollow_vessel_has_its_wall_its_floor_and_two_colours(outline, exponent):
    height, radius, thickness, floor = 0.1, 0.05, 0.004, 0.01
    mesh = hollow(silhouette(height, (radius, radius), 0.001), thickness, floor, (RED, WHITE), outline)
    assert_closed_and_outward(mesh)
    section = np.pi if outline is None else area(outline)
    solid, hole = radius**2 * height, (radius - thickness) ** 2 * (height - floor)
    assert mesh.volume == pytest.approx(section * (solid - hole), rel=0.03)
    x, y, z = mesh.vertices.T
    red = (mesh.colors == RED).all(axis=1)
    radii = (np.abs(x) ** exponent + np.abs(y) ** exponent) ** (1 / exponent)
    assert red[(z < height - 0.001) & (radii > radius - 1e-9)].all()
    assert not red[(z > floor - 1e-9) & (radii < radius - thickness - 1e-6)].any()
    assert z[(radii < 1e-9) & ~red].max() == pytest.approx(floor)
