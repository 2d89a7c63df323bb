import numpy as np
import pytest

from orbitscan.recorder import objects
from orbitscan.recorder.objects import others
from orbitscan.recorder.objects.mesh import merge
from orbitscan.recorder.objects.others.bodies import along_x, carton, domed, hoop, lying, rumpled, tongue
from orbitscan.recorder.objects.others.palette import colors
from orbitscan.recorder.objects.solids import box, circle, cylinder, ellipsoid
from tests.recorder.test_objects import assert_closed_and_outward

SEEDS = range(20)


def instances(name):
    builder = {builder.__name__: builder for builder in others.BUILDERS}[name]
    return [builder(np.random.default_rng(seed)) for seed in SEEDS]


def extents(name):
    return np.array([np.ptp(mesh.vertices, axis=0) for mesh in instances(name)])


def test_no_other_thing_is_one_of_the_ten_categories():
    assert tuple(sorted(objects.CATEGORIES)) == objects.CATEGORIES
    assert len(objects.CATEGORIES) == 10
    assert tuple(sorted(objects.OTHERS)) == objects.OTHERS
    assert len(objects.OTHERS) >= 24
    assert not set(objects.OTHERS) & set(objects.CATEGORIES)
    assert {*objects.OTHERS, *objects.CATEGORIES} <= set(objects.names())


@pytest.mark.parametrize("name", objects.OTHERS)
def test_a_thing_is_what_it_is_for_any_seed(name):
    for mesh in instances(name):
        assert_closed_and_outward(mesh)
        assert np.isfinite(mesh.vertices).all()
        assert 200 < len(mesh.triangles) < 10_000
        assert len(np.unique(mesh.colors, axis=0)) > 1


@pytest.mark.parametrize("name", objects.OTHERS)
def test_instances_differ_in_their_proportions(name):
    sides = extents(name)
    shape = np.sort(sides, axis=1) / sides.max(axis=1, keepdims=True)
    assert np.ptp(shape, axis=0).max() > 0.03


@pytest.mark.parametrize("name", ["comb", "fork", "keyboard", "plate", "scissors", "spoon"])
def test_flat_things_lie_flat(name):
    sides = extents(name)
    assert (sides[:, 2] < 0.2 * sides[:, :2].max(axis=1)).all()


@pytest.mark.parametrize("name", ["desk_lamp", "wine_glass", "ball"])
def test_tall_things_stand(name):
    sides = extents(name)
    assert (sides[:, 2] > 0.7 * sides[:, :2].max(axis=1)).all()


@pytest.mark.parametrize("name", ["pitcher", "wine_glass"])
def test_vessels_are_open_at_the_top(name):
    for mesh in instances(name):
        high = mesh.bounds[1][2]
        axis = mesh.vertices[np.hypot(*mesh.vertices[:, :2].T) < 1e-9]
        assert axis[:, 2].max() < 0.85 * high


def test_keyboards_are_full_and_compact():
    widths = extents("keyboard")[:, 1]
    assert widths.min() < 0.33
    assert widths.max() > 0.40


def test_scissors_are_shut_and_open():
    gaps = []
    for mesh in instances("scissors"):
        x, y, _ = mesh.vertices.T
        gaps.append(np.ptp(y[x > x.max() - 0.004]))
    assert min(gaps) < 0.004
    assert max(gaps) > 0.03


def test_cans_have_the_formats_of_shops():
    sides = extents("soda_can")
    standing = sides[sides[:, 2] > sides[:, 0]]
    assert np.unique(standing[:, 0].round(2)).tolist() == [0.05, 0.06, 0.07]
    assert np.ptp(standing[:, 2]) > 0.04


@pytest.mark.parametrize("name", ["pear", "cereal_box", "mushroom", "headphones", "flashlight"])
def test_some_things_stand_and_some_lie(name):
    sides = extents(name)
    upright = sides[:, 2] / sides[:, :2].max(axis=1)
    assert upright.max() > 1.4 * upright.min()


def test_a_hoop_is_a_torus_open_in_the_middle():
    ring = hoop(circle(0.01, 48), 0.1, 0.1, 96)
    assert_closed_and_outward(ring)
    assert ring.volume == pytest.approx(2 * np.pi**2 * 0.1 * 0.01**2, rel=0.01)
    assert np.hypot(*ring.vertices[:, :2].T).min() == pytest.approx(0.09)
    oval = hoop(circle(0.01, 48), 0.1, 0.05, 96)
    np.testing.assert_allclose(oval.bounds, [[-0.11, -0.06, -0.01], [0.11, 0.06, 0.01]], atol=1e-12)


def test_a_body_along_x_has_its_sections_at_their_places():
    square = np.array([(-1, 0), (1, 0), (1, 2), (-1, 2)])
    body = along_x(np.array([0, 3.0]), np.stack([square, square]))
    assert_closed_and_outward(body)
    assert body.volume == pytest.approx(12)
    np.testing.assert_allclose(body.bounds, [[0, -1, 0], [3, 1, 2]])


def test_a_carton_is_a_box_or_swells():
    assert carton(0.2, 0.1, 0.3).volume == pytest.approx(0.2 * 0.1 * 0.3)
    swollen = carton(0.2, 0.1, 0.3, 0.004)
    assert_closed_and_outward(swollen)
    assert swollen.volume > 0.2 * 0.1 * 0.3
    np.testing.assert_allclose(swollen.bounds, [[-0.104, -0.054, 0], [0.104, 0.054, 0.3]], atol=2e-4)


def test_a_tongue_is_as_thick_as_given_and_its_edges_stand_up():
    x, ones = np.linspace(0, 0.1, 9), np.ones(9)
    strip = tongue(x, 0.02 * ones, 0.003 * ones, 0.004 * ones, 0.001 * ones)
    assert_closed_and_outward(strip)
    assert strip.volume == pytest.approx(0.1 * 0.04 * 0.001)
    np.testing.assert_allclose(strip.bounds, [[0, -0.02, 0.003], [0.1, 0.02, 0.008]], atol=1e-12)


@pytest.mark.parametrize("squareness", [2, 3.5, 5])
def test_a_dome_stands_on_zero_and_is_as_wide_and_high_as_given(squareness):
    outline = domed(0.03, 0.05, squareness)
    np.testing.assert_allclose(outline.min(axis=0), [-0.03, 0], atol=1e-12)
    np.testing.assert_allclose(outline.max(axis=0), [0.03, 0.05], atol=1e-12)


def test_what_is_rumpled_stays_closed_and_close():
    ball = ellipsoid(0.05, 0.05, 0.05, 32)
    moved = rumpled(np.random.default_rng(4), ball, 0.003)
    assert_closed_and_outward(moved)
    shift = np.linalg.norm(moved.vertices - ball.vertices, axis=1)
    assert 0.001 < shift.mean() < 0.01
    assert shift.max() < 0.02


def test_lying_turns_up_into_forward():
    np.testing.assert_allclose(lying(cylinder(0.1, 1)).bounds, [[0, -0.1, -0.1], [1, 0.1, 0.1]], atol=1e-12)


def test_colours_differ():
    for seed in SEEDS:
        assert len(set(colors(np.random.default_rng(seed), 3))) == 3
    assert len(merge([box(1, 1, 1).painted(color) for color in colors(np.random.default_rng(1), 2)]).colors) == 20
