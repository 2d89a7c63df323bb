import numpy as np
import pytest

from orbitscan.recorder import objects
from orbitscan.recorder.objects import pliers
from orbitscan.recorder.objects.pliers.adjustable import tongue_and_groove
from orbitscan.recorder.objects.pliers.fixed import cutters, mini, needle_nose
from orbitscan.recorder.objects.pliers.lever import MIDDLE, crossed, finish, handle, handle_path, jaw, opening, over
from tests.recorder.test_objects import assert_closed_and_outward

SEEDS = range(15)


def extents(style):
    return np.array([np.ptp(style(np.random.default_rng(seed)).vertices, axis=0) for seed in SEEDS])


@pytest.mark.parametrize("style", pliers.STYLES)
def test_every_style_is_closed_and_lies_flat(style):
    for seed in SEEDS:
        mesh = style(np.random.default_rng(seed))
        assert_closed_and_outward(mesh)
        length, width, height = np.ptp(mesh.vertices, axis=0)
        assert 0.08 < length < 0.29
        assert 0.03 < width < 0.8 * length + 0.05
        assert 0.010 < height < 0.045


def test_the_first_style_is_the_pliers_of_earlier_recordings():
    mesh = objects.build("pliers")
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.19008741, 0.11766709, 0.01816], atol=1e-8)


def test_needle_noses_are_long_and_mini_pliers_short():
    long, short = extents(needle_nose)[:, 0], extents(mini)[:, 0]
    assert long.min() > 0.15
    assert short.max() < 0.14


def test_some_needle_noses_bend_up_and_both_jaws_do():
    heights = extents(needle_nose)[:, 2]
    assert (heights > 0.019).any()
    for seed in np.flatnonzero(heights > 0.019):
        x, _, z = needle_nose(np.random.default_rng(seed)).vertices.T
        assert z[x > x.max() - 0.004].min() > MIDDLE


def test_the_head_of_cutters_is_short():
    for seed in SEEDS:
        x = cutters(np.random.default_rng(seed)).vertices[:, 0]
        assert x.max() < 0.052


def test_the_jaws_of_tongue_and_groove_pliers_stand_at_an_angle():
    for seed in SEEDS:
        x, y, _ = tongue_and_groove(np.random.default_rng(seed)).vertices.T
        tips = x > 0.02
        assert np.degrees(np.arctan2(y[tips].mean(), x[tips].mean())) > 20


def test_pliers_come_shut_and_wide_open():
    angles = np.array([opening(np.random.default_rng(seed), 40) for seed in range(300)])
    assert 0.3 < np.mean(angles < 4) < 0.5
    assert angles.max() > 35
    assert angles.min() >= 0


def test_a_jaw_is_as_wide_and_high_as_asked():
    x = np.linspace(0, 0.05, 10)
    edge = jaw(np.column_stack([x, 0 * x]), np.column_stack([x, 0 * x + 0.01]), np.full(10, 0.008), 0.002)
    assert_closed_and_outward(edge)
    np.testing.assert_allclose(
        edge.bounds, [[0, 0, MIDDLE + 0.002 - 0.004], [0.05, 0.01, MIDDLE + 0.002 + 0.004]], atol=1e-12
    )


def test_handles_are_straight_or_bowed():
    straight, bowed = handle_path(0.12, 0, 0.03, 1.0), handle_path(0.12, 0, 0.03, 0.0)
    assert straight[:, 1].argmin() == len(straight) - 1
    assert 10 < bowed[:, 1].argmin() < 30
    np.testing.assert_allclose([straight[:, 1].min(), bowed[:, 1].min()], -0.03, atol=1e-3)


def test_a_lever_turned_over_keeps_its_plane_and_crosses():
    look = finish(np.random.default_rng(1))
    lever = handle(handle_path(0.12, 0.005, 0.02, 0.5), look)
    for part in lever:
        low, high = part.bounds
        below, above = over(part).bounds
        np.testing.assert_allclose([below[1], above[1]], [-high[1], -low[1]])
        assert below[2] + above[2] == pytest.approx(4 * MIDDLE - (low[2] + high[2]))
    shut, wide = (crossed(lever, lever, degrees, 0.014, look) for degrees in (0, 30))
    assert np.ptp(wide.vertices[:, 1]) > np.ptp(shut.vertices[:, 1]) + 0.03
