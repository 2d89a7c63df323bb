import numpy as np
import pytest

from orbitscan.recorder.objects import build, coffee_mug
from orbitscan.recorder.objects.handle import BOWS, handle
from orbitscan.recorder.objects.vessel import silhouette
from tests.recorder.test_objects import assert_closed_and_outward

STYLES = coffee_mug.STYLES
MANY = range(1, 5 * len(STYLES) + 1)


@pytest.fixture(scope="module")
def mugs():
    return [build("coffee_mug", instance) for instance in MANY]


@pytest.mark.parametrize("style", STYLES)
def test_a_mug_of_any_style_is_open_down_to_its_floor(style):
    for seed in range(4):
        mesh = style(np.random.default_rng(seed))
        assert_closed_and_outward(mesh)
        radii, z = np.hypot(*mesh.vertices.T[:2]), mesh.vertices[:, 2]
        height = z.max()
        rim = radii[z > 0.97 * height].min()
        assert radii[z > 0.4 * height].min() > 0.6 * rim
        floors = np.unique(z[radii < 1e-9])
        assert len(floors) == 2
        assert floors[0] < 0.005
        assert floors[0] + 0.0025 < floors[1] < 0.2 * height


@pytest.mark.parametrize("style", STYLES)
def test_the_handle_is_one_bow_at_the_right_hand_with_room_for_a_finger(style):
    for seed in range(6):
        x, y, z = style(np.random.default_rng(seed)).vertices.T
        body = -y.min()
        beyond = y > body + 0.004
        assert np.abs(x[beyond]).max() < 0.014
        assert x.max() == pytest.approx(-x.min(), abs=1e-6)
        assert y.max() - body > 0.010
        assert z[beyond].min() > 0.02 * z.max()
        assert z[beyond].max() < 1.02 * z.max()


def test_proportions_are_those_of_a_shop(mugs):
    sizes = np.array([np.ptp(mug.vertices, axis=0) for mug in mugs])
    across, along, height = sizes.T
    slender = height / across
    assert slender.min() < 0.72  # a tea cup
    assert slender.max() > 1.4  # a latte
    assert height.min() < 0.065
    assert height.max() > 0.12
    reach = along - across
    assert reach.min() < 0.02
    assert reach.max() > 0.045


@pytest.mark.parametrize("bow", BOWS)
def test_a_handle_reaches_as_far_as_its_family_says_and_starts_in_the_wall(bow):
    wall = silhouette(0.09, (0.04, 0.04))
    for seed in range(5):
        mesh = handle(np.random.default_rng(seed), bow, wall, 0.003)
        assert_closed_and_outward(mesh)
        y, z = mesh.vertices[:, 1], mesh.vertices[:, 2]
        half = 0.0075  # of the thickest rod
        assert bow.reach[0] <= y.max() - 0.04 <= bow.reach[1] + half
        ends = mesh.vertices[-2:]
        np.testing.assert_allclose(ends[:, 1], 0.037, atol=2e-5)
        low, high = ends[:, 2] / 0.09
        assert bow.lower[0] <= low <= bow.lower[1]
        assert bow.upper[0] <= high <= bow.upper[1]
        assert np.ptp(z) > 0.3 * 0.09
