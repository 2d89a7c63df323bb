import numpy as np
import pytest

from orbitscan.recorder.objects import bowl, build
from tests.recorder.test_objects import assert_closed_and_outward


@pytest.mark.parametrize("style", bowl.STYLES)
def test_a_bowl_of_any_style_is_open_and_has_no_handle(style):
    for seed in range(5):
        mesh = style(np.random.default_rng(seed))
        assert_closed_and_outward(mesh)
        x, y, z = mesh.vertices.T
        radii, height = np.hypot(x, y), np.ptp(z)
        assert z.min() == pytest.approx(0, abs=1e-9)
        floors = np.unique(z[radii < 1e-9])
        assert len(floors) == 2
        assert floors[0] + 0.0015 < floors[1] < z.min() + 0.4 * height
        assert radii[z > 0.6 * height].min() > 0.4 * radii.max()  # nothing spans it
        assert np.ptp(x) == pytest.approx(np.ptp(y), rel=0.16)
        assert 0.2 < height / np.ptp(x) < 0.75


def test_bowls_are_from_almost_plates_to_deep_and_from_dips_to_salad_bowls():
    sizes = np.array([np.ptp(build("bowl", instance).vertices, axis=0) for instance in range(1, 61)])
    share = sizes[:, 2] / sizes[:, 0]
    assert share.min() < 0.27
    assert share.max() > 0.55
    assert sizes[:, 0].min() < 0.095
    assert sizes[:, 0].max() > 0.22


@pytest.mark.parametrize("style", bowl.STYLES)
def test_only_the_round_styles_look_the_same_from_all_sides(style):
    mesh = style(np.random.default_rng(1))
    z, radii = mesh.vertices[:, 2].round(9), np.hypot(*mesh.vertices.T[:2])
    top = z == np.unique(z)[len(np.unique(z)) // 2]
    outer = radii[top][radii[top] > 0.5 * radii[top].max()]
    rows = outer.reshape(-1, bowl.SEGMENTS)
    assert (np.ptp(rows, axis=1) < 1e-9).all() == (style in bowl.ROUND)
