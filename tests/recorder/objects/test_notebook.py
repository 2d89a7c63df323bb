import numpy as np
import pytest

from orbitscan.recorder import objects
from orbitscan.recorder.objects import notebook
from orbitscan.recorder.objects.notebook.opened import open_coiled, open_flat
from orbitscan.recorder.objects.notebook.paper import ACROSS, bent, coil, level, page_size, stack, waves
from orbitscan.recorder.objects.notebook.shut import coiled, hard_cover, pad, soft_cover
from tests.recorder.test_objects import assert_closed_and_outward

SEEDS = range(15)


def sides(style):
    return np.array([np.ptp(style(np.random.default_rng(seed)).vertices, axis=0) for seed in SEEDS])


@pytest.mark.parametrize("style", notebook.STYLES)
def test_every_style_is_closed_at_many_seeds(style):
    for seed in SEEDS:
        mesh = style(np.random.default_rng(seed))
        assert_closed_and_outward(mesh)
        assert np.isfinite(mesh.vertices).all()
        assert 1000 < len(mesh.triangles) < 10_000


@pytest.mark.parametrize("style", [hard_cover, soft_cover, coiled, pad])
def test_a_shut_notebook_is_flat_and_of_a_page_in_size(style):
    x, y, z = sides(style).T
    assert (np.maximum(x, y) < 0.32).all()
    assert (np.minimum(x, y) > 0.085).all()
    assert (z < 0.35 * np.maximum(x, y)).all()


def test_an_open_notebook_is_two_pages_wide_and_lower_at_its_gutter_than_at_its_arch():
    for seed in SEEDS:
        x, y, z = open_flat(np.random.default_rng(seed)).vertices.T
        assert np.ptp(y) > 1.15 * np.ptp(x)
        gutter = z[np.abs(y) < 0.0005].max()  # the start of a leaf that stands counts too
        assert gutter < 0.6 * z.max()


def test_an_open_coil_lies_beside_or_above():
    x, y, _ = sides(open_coiled).T
    assert (y > 1.1 * x).any()
    assert (x > 1.1 * y).any()


def test_notebooks_come_thick_and_thin_from_pocket_to_a4():
    sizes = np.array([np.ptp(objects.build("notebook", i).vertices, axis=0) for i in range(1, 85)])
    longest = sizes[:, :2].max(axis=1)
    assert longest.min() < 0.16
    assert longest.max() > 0.29
    assert np.percentile(sizes[:, 2], 10) < 0.018
    assert np.percentile(sizes[:, 2], 90) > 0.03


def test_a_level_stack_is_a_block():
    for side in (1, -1):
        block = stack(0.2, level(side * 0.1, 0.003), 0.02)
        assert_closed_and_outward(block)
        assert block.volume == pytest.approx(0.2 * 0.1 * 0.02)
        low, high = block.bounds
        np.testing.assert_allclose([low[2], high[2]], [0.003, 0.023])


def test_a_round_corner_takes_its_share_of_both_corners_at_the_far_end():
    corner = 0.02
    block = stack(0.2, level(0.1, corner=corner), 0.01, corner)
    assert_closed_and_outward(block)
    missing = (2 - np.pi / 2) * corner**2
    assert block.volume == pytest.approx((0.2 * 0.1 - missing) * 0.01, rel=4e-3)


def test_a_bent_leaf_keeps_its_length_and_ends_at_its_slopes():
    profile = bent(0.15, np.array([60.0, -30.0]), (0.0, 0.01))
    steps = np.diff(profile, axis=0)
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(0.15)
    np.testing.assert_allclose(np.degrees(np.arctan2(steps[[0, -1], 1], steps[[0, -1], 0])), [60, -30])
    leaf = stack(0.2, profile, 0.0005)
    assert_closed_and_outward(leaf)
    assert leaf.volume == pytest.approx(0.2 * 0.15 * 0.0005, rel=0.02)
    assert len(leaf.vertices) == 2 * ACROSS * len(profile)


def test_waves_stay_within_their_height():
    rise = waves(np.random.default_rng(3), 0.2, 0.1, 0.004)
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, 40), np.linspace(0, 0.1, 30))
    assert rise(x, y).min() >= 0
    assert 0.0005 < rise(x, y).max() <= 0.004


def test_a_coil_keeps_its_radius_and_length():
    for seed in SEEDS:
        wire = coil(np.random.default_rng(seed), 0.2, 0.008)
        assert_closed_and_outward(wire)
        radius = np.hypot(*wire.vertices.T[1:])
        assert radius.min() > 0.0062
        assert radius.max() < 0.0096
        assert np.ptp(wire.vertices[:, 0]) == pytest.approx(0.2, abs=0.004)


def test_pages_come_in_both_directions():
    rng = np.random.default_rng(5)
    height, width = np.array([page_size(rng) for _ in range(200)]).T
    assert 0.05 < np.mean(width > height) < 0.35
    assert np.maximum(height, width).max() <= 0.30


def test_a_notebook_of_any_style_comes_from_the_generator():
    counts = {len(notebook.build(np.random.default_rng(seed)).triangles) for seed in range(30)}
    assert len(counts) >= 6
