"""What a sensor looked through is empty: in front of what it saw, not behind, and beside it is another matter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.processing.registration.free_space import IN_FRONT, UNSEEN, look, make_range_image
from orbitscan.recorder import poses
from tests.geometry import random_pose

PIXEL, TOLERANCE = 0.004, 0.005


def wall(depth=1.0, step=0.002, half=0.1):
    """Points (N, 3) of a square wall before a sensor in the origin."""
    x, y = np.meshgrid(*2 * [np.arange(-half, half + step / 2, step)])
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, depth)])


@pytest.fixture(scope="module")
def image():
    return make_range_image(wall(), np.zeros(3), PIXEL)


def looked_up(image, point, tolerance=TOLERANCE):
    seen = look(image, np.asarray(point, dtype=float), tolerance)
    return seen == IN_FRONT, seen == UNSEEN


@pytest.mark.parametrize(
    ("point", "in_front", "unseen"),
    [
        ((0, 0, 0.9), True, False),
        ((0.04, -0.05, 0.5), True, False),
        ((0, 0, 1.0), False, False),
        ((0, 0, 1.0 - 0.8 * TOLERANCE), False, False),
        ((0, 0, 1.0 - 1.2 * TOLERANCE), True, False),
        ((0.05, 0.05, 1.3), False, False),
        ((0.3, 0, 1.0), False, True),
        ((0, 0.13, 1.0), False, True),
        ((0, 0, -0.5), False, True),
        ((0, 0, 0), False, True),
    ],
    ids=[
        "before",
        "far before",
        "on",
        "within",
        "just before",
        "behind",
        "beside",
        "above",
        "behind the sensor",
        "in it",
    ],
)
def test_before_behind_and_beside_a_wall(image, point, in_front, unseen):
    assert looked_up(image, point) == (in_front, unseen)


def test_a_hole_in_the_wall_was_not_seen(image):
    points = wall()
    holed = make_range_image(points[np.linalg.norm(points[:, :2], axis=1) > 0.03], np.zeros(3), PIXEL)
    assert looked_up(holed, (0, 0, 1.0)) == (False, True)
    assert looked_up(holed, (0, 0, 0.9)) == (False, True)  # the background may be what was not measured
    assert looked_up(holed, (0.06, 0, 0.9)) == (True, False)


def test_a_single_missing_point_is_no_hole():
    points = wall()
    thin = make_range_image(np.delete(points, len(points) // 2, axis=0), np.zeros(3), 0.002)
    assert looked_up(thin, (0, 0, 0.9)) == (True, False)


def test_at_an_edge_the_nearer_surface_counts():
    """Where a nearer wall ends, nobody can tell to the pixel: only what is before both contradicts."""
    near = wall(0.8)
    both = make_range_image(np.vstack([wall(), near[near[:, 0] > 0]]), np.zeros(3), PIXEL)
    edge = (-0.001, 0, 0.9)
    assert looked_up(both, edge) == (False, False)
    assert looked_up(both, (-0.02, 0, 0.9)) == (True, False)
    assert looked_up(both, (-0.001, 0, 0.7)) == (True, False)


@given(st.integers(0, 10**6))
def test_where_the_sensor_stands_and_how_it_is_turned_does_not_show(seed):
    rng = np.random.default_rng(seed)
    T = random_pose(rng)
    cloud = wall()
    moved = make_range_image(poses.transform(T, cloud), T[:3, 3], PIXEL)
    before = rng.uniform([-0.09, -0.09, 0.3], [0.09, 0.09, 0.98], size=(50, 3))
    before[:, :2] *= before[:, 2:]  # inside the pyramid
    behind = before + np.array([0, 0, 1.0])
    aside = before + np.array([0.5, 0, 0])
    for points, expected in ((before, (True, False)), (behind, (False, None)), (aside, (False, True))):
        in_front, unseen = np.array([looked_up(moved, point) for point in poses.transform(T, points)]).T
        assert (in_front == expected[0]).all()
        assert expected[1] is None or (unseen == expected[1]).all()


def test_a_sensor_that_does_not_look_along_z():
    """Range scanners are recorded far down -z, off the view's own origin."""
    cloud = wall(0.0)
    image = make_range_image(cloud, np.array([0.3, 0, -2.0]), PIXEL)
    assert looked_up(image, (0.015, 0, -0.1)) == (True, False)
    assert looked_up(image, (0.0, 0, 0.1)) == (False, False)


def test_a_stray_point_makes_the_image_coarser_and_not_larger():
    points = np.vstack([wall(), [[900.0, 900.0, 1.0]]])
    image = make_range_image(points, np.zeros(3), 1e-5)
    assert image.near.size < 6_000_000
    assert image.size > 1e-5
    assert looked_up(image, (0, 0, 2.0), 0.005) == (False, False)


def test_a_stray_point_before_the_sensor_only_hides_what_is_around_it():
    points = np.vstack([wall(), [[0.02, 0.0, 0.5]]])
    image = make_range_image(points, np.zeros(3), PIXEL)
    assert looked_up(image, (0.036, 0, 0.9)) == (False, False)  # on the ray of the stray point, behind it
    assert looked_up(image, (-0.05, 0, 0.9)) == (True, False)


def test_points_behind_the_sensor_are_no_part_of_the_image():
    image = make_range_image(np.vstack([wall(), [[0.0, 0, -1.0]]]), np.zeros(3), PIXEL)
    assert np.nanmin(image.near) > 0
    assert looked_up(image, (0, 0, 0.9)) == (True, False)


def test_amid_the_points_there_is_no_image():
    """A room scanned from within: half of what the sensor saw lies behind any image of it."""
    u = np.random.default_rng(0).normal(size=(2000, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    assert make_range_image(u, np.array([0.2, 0, 0]), PIXEL) is None
    assert make_range_image(np.vstack([u, -u]), np.zeros(3), PIXEL) is None  # nowhere to look to


def test_a_point_beside_the_sensor_does_not_widen_the_image():
    image = make_range_image(np.vstack([wall(), [[0.5, 0.0, 1e-9]]]), np.zeros(3), PIXEL)
    assert image.size == pytest.approx(PIXEL, rel=0.01)
    assert looked_up(image, (0, 0, 0.9)) == (True, False)
