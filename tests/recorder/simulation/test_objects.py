"""What holds for every parametric object, and the solids they are made of."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.mesh import Mesh, merge
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.objects.solids import box, circle, cylinder, ellipsoid, loft, prism, revolve, sweep
from tests.recorder.simulation.objects.shapes import assert_closed_and_outward, built, extents, instances

SIZES = {  # metres: the least and the largest of every side of the bounding box
    "apple": ((0.055, 0.055, 0.045), (0.105, 0.105, 0.12)),
    "bell_pepper": ((0.045, 0.045, 0.045), (0.155, 0.11, 0.155)),
    "dry_battery": ((0.0095, 0.0095, 0.0095), (0.117, 0.138, 0.138)),
    "robot": ((0.30, 0.25, 0.34), (0.50, 0.40, 0.50)),
    "bin": ((0.22, 0.20, 0.30), (0.36, 0.27, 0.45)),
    "coffee_mug": ((0.05, 0.075, 0.045), (0.12, 0.17, 0.135)),
    "bowl": ((0.085, 0.085, 0.035), (0.245, 0.245, 0.13)),
    "cap": ((0.20, 0.11, 0.05), (0.29, 0.19, 0.165)),
    "cell_phone": ((0.008, 0.04, 0.009), (0.205, 0.165, 0.16)),
    "helicopter": ((0.36, 0.12, 0.18), (0.50, 0.42, 0.24)),
    "notebook": ((0.085, 0.085, 0.005), (0.345, 0.42, 0.24)),
    "pliers": ((0.08, 0.03, 0.011), (0.29, 0.20, 0.04)),
    "statue": ((0.14, 0.22, 0.32), (0.25, 0.34, 0.50)),
    "vacuum_cleaner": ((0.35, 0.23, 0.38), (0.50, 0.32, 0.50)),
    "water_bottle": ((0.047, 0.055, 0.145), (0.10, 0.11, 0.335)),
    "ball": ((0.066, 0.066, 0.095), (0.234, 0.218, 0.405)),
    "banana": ((0.127, 0.036, 0.027), (0.227, 0.195, 0.068)),
    "bread_loaf": ((0.11, 0.082, 0.069), (0.34, 0.178, 0.136)),
    "calculator": ((0.091, 0.06, 0.011), (0.218, 0.164, 0.068)),
    "camera": ((0.034, 0.078, 0.049), (0.194, 0.169, 0.125)),
    "cereal_box": ((0.045, 0.079, 0.045), (0.392, 0.237, 0.402)),
    "comb": ((0.11, 0.026, 0.003), (0.31, 0.073, 0.038)),
    "computer_mouse": ((0.081, 0.047, 0.024), (0.231, 0.08, 0.05)),
    "desk_lamp": ((0.135, 0.099, 0.17), (0.309, 0.26, 0.424)),
    "flashlight": ((0.028, 0.026, 0.026), (0.283, 0.099, 0.277)),
    "food_bag": ((0.08, 0.054, 0.026), (0.316, 0.214, 0.293)),
    "food_can": ((0.056, 0.056, 0.031), (0.115, 0.115, 0.224)),
    "fork": ((0.129, 0.017, 0.007), (0.229, 0.074, 0.015)),
    "frying_pan": ((0.136, 0.243, 0.028), (0.282, 0.467, 0.148)),
    "hammer": ((0.229, 0.081, 0.019), (0.412, 0.174, 0.083)),
    "hand_towel": ((0.157, 0.068, 0.038), (0.369, 0.39, 0.171)),
    "headphones": ((0.051, 0.159, 0.052), (0.217, 0.266, 0.219)),
    "keyboard": ((0.087, 0.221, 0.011), (0.225, 0.509, 0.044)),
    "light_bulb": ((0.059, 0.028, 0.028), (0.153, 0.106, 0.109)),
    "marker": ((0.106, 0.015, 0.011), (0.174, 0.06, 0.048)),
    "milk_carton": ((0.056, 0.057, 0.108), (0.117, 0.112, 0.304)),
    "mushroom": ((0.034, 0.038, 0.026), (0.097, 0.105, 0.092)),
    "pear": ((0.052, 0.054, 0.055), (0.153, 0.09, 0.161)),
    "pitcher": ((0.081, 0.127, 0.141), (0.207, 0.319, 0.294)),
    "plate": ((0.135, 0.135, 0.012), (0.314, 0.314, 0.04)),
    "scissors": ((0.104, 0.07, 0.007), (0.295, 0.187, 0.014)),
    "screwdriver": ((0.095, 0.018, 0.019), (0.307, 0.039, 0.04)),
    "shoe": ((0.142, 0.05, 0.053), (0.336, 0.127, 0.233)),
    "soda_can": ((0.046, 0.046, 0.052), (0.2, 0.074, 0.203)),
    "sponge": ((0.081, 0.035, 0.023), (0.234, 0.15, 0.098)),
    "spoon": ((0.114, 0.023, 0.009), (0.305, 0.054, 0.024)),
    "stapler": ((0.084, 0.024, 0.038), (0.213, 0.051, 0.189)),
    "tape_roll": ((0.036, 0.012, 0.011), (0.25, 0.138, 0.137)),
    "tissue_box": ((0.095, 0.096, 0.042), (0.174, 0.281, 0.242)),
    "toothbrush": ((0.141, 0.012, 0.011), (0.217, 0.025, 0.027)),
    "toy_car": ((0.066, 0.031, 0.018), (0.262, 0.141, 0.103)),
    "wine_glass": ((0.052, 0.052, 0.126), (0.158, 0.158, 0.248)),
}
TURNLESS = [  # and the least distance of its 20 farthest vertices from itself, turned [m]
    ("robot", 0.02),
    ("bin", 0.01),
    ("statue", 0.02),
    ("helicopter", 0.02),
    ("vacuum_cleaner", 0.02),
    ("cap", 0.01),
]
FIRST = {  # metres: the sides of the first instance, which recordings have been made of
    "cap": (0.2589315, 0.15941788, 0.11377543),
    "pliers": (0.19008741, 0.11766709, 0.01816),
}
SQUARE = circle(1, 4)
ALONG_X = np.array([(0, 0, 0), (1, 0, 0), (3, 0, 0)])
SOLIDS = {  # and their volumes and sides
    "box": (box(0.3, 0.2, 0.1), 0.006, (0.3, 0.2, 0.1)),
    "cylinder": (cylinder(0.2, 0.5, segments=96), np.pi * 0.02, (0.4, 0.4, 0.5)),
    "ellipsoid": (ellipsoid(0.1, 0.2, 0.3, segments=96), 4 / 3 * np.pi * 0.006, (0.2, 0.4, 0.6)),
    "cone": (revolve(np.array([(0, 0), (1, 0), (0, 3)]), 96), np.pi, (2, 2, 3)),
    "cone, its outline given downwards": (revolve(np.array([(0, 3), (1, 0), (0, 0)]), 96), np.pi, (2, 2, 3)),
    "cup": (revolve(np.array([(0, 0), (2, 0), (2, 3), (1, 3), (1, 1), (0, 1)]), 96), np.pi * 10, (4, 4, 3)),
    "prism": (prism(SQUARE, 3), 6, (2, 2, 3)),
    "pyramid": (loft(np.stack([np.pad(SQUARE, ((0, 0), (0, 1))), np.tile([0, 0, 3.0], (4, 1))])), 2, (2, 2, 3)),
    "bar": (sweep(SQUARE, ALONG_X), 6, (3, 2, 2)),
    "tapered bar": (sweep(SQUARE, ALONG_X, scales=np.array([[3.0], [2.0], [0.0]])), 18, (3, 6, 6)),
}
every_object = pytest.mark.parametrize("name", objects.names())


def test_the_categories_are_ten_in_order_and_no_other_thing_is_one_of_them():
    assert len(objects.CATEGORIES) == 10
    assert tuple(sorted(objects.CATEGORIES)) == objects.CATEGORIES
    assert tuple(sorted(objects.OTHERS)) == objects.OTHERS
    assert len({*objects.OTHERS, *objects.CATEGORIES}) == len(objects.OTHERS) + 10
    assert {*objects.OTHERS, *objects.CATEGORIES} < set(objects.names())


@every_object
def test_an_object_is_closed_coloured_of_its_real_size_and_stands_in_the_middle_of_the_table(name):
    for mesh in instances(name):
        assert np.isfinite(mesh.vertices).all()
        assert (200 if name in objects.OTHERS else 1000) < len(mesh.triangles) < 10_000
        assert_closed_and_outward(mesh)
        assert mesh.colors.shape == mesh.vertices.shape
        assert mesh.colors.dtype == np.uint8
        assert len(np.unique(mesh.colors, axis=0)) > 1
        low, high = mesh.bounds
        assert low[2] == pytest.approx(0, abs=1e-12)
        np.testing.assert_allclose((low + high)[:2], 0, atol=1e-12)
        assert (high - low >= SIZES[name][0]).all()
        assert (high - low <= SIZES[name][1]).all()


@every_object
def test_an_instance_is_always_the_same_and_never_another_one(name):
    first, again = built(name), objects.build(name)
    for one, other in (
        (first.vertices, again.vertices),
        (first.triangles, again.triangles),
        (first.colors, again.colors),
    ):
        np.testing.assert_array_equal(one, other)
    shapes = [mesh.vertices for mesh in instances(name)]
    for i, shape in enumerate(shapes):
        for other in shapes[:i]:
            assert shape.shape != other.shape or np.abs(shape - other).max() > 0.002


@pytest.mark.parametrize("name", FIRST)
def test_the_first_instance_is_that_of_earlier_recordings(name):
    np.testing.assert_allclose(extents([built(name)])[0], FIRST[name], atol=1e-8)


@pytest.mark.parametrize(("name", "least"), TURNLESS)
def test_no_turn_about_the_vertical_maps_the_object_onto_itself(name, least):
    vertices = built(name).vertices
    tree = cKDTree(vertices)
    for degrees in range(20, 360, 20):
        distance, _ = tree.query(Mesh(vertices, np.empty((0, 3), int)).turned("z", degrees).vertices)
        assert np.sort(distance)[-20] > least


@pytest.mark.parametrize("name", ["robot", "statue", "helicopter", "vacuum_cleaner"])
def test_an_object_of_no_symmetry_is_no_mirror_image_of_itself(name):
    vertices = built(name).vertices
    distance, _ = cKDTree(vertices).query(vertices * (1, -1, 1))
    assert np.mean(distance > 0.01) > 0.08


def test_an_unknown_object_names_the_known_ones():
    with pytest.raises(InvalidOption, match=r"^teapot: not a known object; choose one of bin, coffee_mug, robot, "):
        objects.build("teapot")


def test_an_instance_below_one_is_refused():
    with pytest.raises(InvalidOption, match="instance 0"):
        objects.build("robot", 0)


@pytest.mark.parametrize(("solid", "volume", "sides"), SOLIDS.values(), ids=SOLIDS.keys())
def test_a_solid_has_its_volume_and_its_size(solid, volume, sides):
    assert_closed_and_outward(solid)
    assert solid.volume == pytest.approx(volume, rel=5e-3)
    np.testing.assert_allclose(extents([solid])[0], sides, rtol=2e-3)


def test_merged_parts_keep_their_places_and_colours():
    red, blue = (255, 0, 0), (0, 0, 255)
    both = merge([box(1, 1, 1).painted(red), box(2, 1, 1).turned("z", 90).moved(z=2).painted(blue)])
    assert_closed_and_outward(both)
    assert both.volume == pytest.approx(3)
    assert (both.colors == np.where(both.vertices[:, 2:] < 1.5, red, blue)).all()
    np.testing.assert_allclose(both.bounds, [[-0.5, -1, 0], [0.5, 1, 3]], atol=1e-12)
