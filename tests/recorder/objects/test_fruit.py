import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.recorder.objects.fruit import bumps, settled
from orbitscan.recorder.objects.mesh import Mesh
from orbitscan.recorder.objects.solids import box, ellipsoid


@pytest.mark.parametrize("tilt", [0, 8, -12])
def test_a_box_set_down_askew_comes_to_stand_flat(tilt):
    upright = box(0.06, 0.05, 0.04)
    resting = settled(upright, tilt, reach_deg=20)
    np.testing.assert_allclose(np.ptp(resting.vertices[:, 2]), 0.04, atol=1e-12)
    np.testing.assert_allclose(resting.volume, upright.volume)


def test_a_box_tilted_over_lies_with_its_axis_to_the_front():
    askew = box(0.06, 0.05, 0.09).turned("z", 30)
    cap = askew.vertices[:, 2] > 0.05
    resting = settled(askew, 85, reach_deg=50)
    axis = resting.vertices[cap].mean(axis=0) - resting.vertices[~cap].mean(axis=0)
    np.testing.assert_allclose(axis, [0.09, 0, 0], atol=1e-12)
    np.testing.assert_allclose(np.ptp(resting.vertices[:, 2]), 0.06, atol=1e-12)  # on the side nearest to below


def test_an_egg_within_reach_of_its_long_side_falls_onto_it():
    egg = ellipsoid(0.03, 0.03, 0.045, 40)
    height = np.ptp(settled(egg, 70, reach_deg=25).vertices[:, 2])
    assert height == pytest.approx(0.06, abs=0.0005)
    assert np.ptp(settled(egg, 0, reach_deg=5).vertices[:, 2]) > 0.085


def test_a_body_that_finds_no_face_stays_as_it_was_tilted():
    upright = box(0.06, 0.05, 0.04)
    expected = Rotation.from_euler("y", 30, degrees=True).apply(upright.vertices)
    np.testing.assert_allclose(settled(upright, 30, reach_deg=5).vertices, expected, atol=1e-12)


def test_bumps_are_smooth_and_of_their_size():
    rng = np.random.default_rng(0)
    directions = ellipsoid(1, 1, 1, 48).vertices
    near = Mesh(directions, np.empty((0, 3), int)).turned("x", 2).vertices
    sizes = []
    for seed in range(60):
        field = bumps(np.random.default_rng(seed), directions, 0.02)
        step = field - bumps(np.random.default_rng(seed), near, 0.02)
        assert np.abs(step).max() < 0.02 / 2 * 8 * 4 * np.radians(2)
        sizes.append(field)
    assert np.sqrt(np.mean(np.square(sizes))) == pytest.approx(0.02, rel=0.1)
    assert bumps(rng, directions.reshape(-1, 2, 3), 0.02).shape == (len(directions) // 2, 2)
