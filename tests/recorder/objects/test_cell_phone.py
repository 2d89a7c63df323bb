import numpy as np
import pytest

from orbitscan.recorder import objects
from orbitscan.recorder.objects import cell_phone
from orbitscan.recorder.objects.cell_phone.body import body, keypad
from orbitscan.recorder.objects.cell_phone.folding import flip_open, flip_shut
from tests.recorder.test_objects import assert_closed_and_outward

SEEDS = range(20)


def sides(mesh):
    return np.sort(np.ptp(mesh.vertices, axis=0))


@pytest.mark.parametrize("style", cell_phone.STYLES)
def test_every_style_is_a_slender_thing_that_fits_a_hand(style):
    for seed in SEEDS:
        mesh = style(np.random.default_rng(seed))
        assert_closed_and_outward(mesh)
        principal = np.linalg.svd(mesh.vertices - mesh.vertices.mean(axis=0), full_matrices=False)[2]
        length = np.ptp(mesh.vertices @ principal[0])
        assert 0.085 < length < 0.21


def test_most_phones_lie_flat_and_some_lean():
    heights = np.array([np.ptp(objects.build("cell_phone", i).vertices[:, 2]) for i in range(1, 85)])
    assert 0.6 < np.mean(heights < 0.05) < 0.95
    assert np.sum(heights > 0.06) >= 4


def test_an_open_flip_phone_is_nearly_two_shut_ones_long():
    for seed in SEEDS:
        both = flip_open(np.random.default_rng(seed)).vertices
        assert np.ptp(both[:, 0]) > 0.11
        keys, screen = both[both[:, 0] > 0.02], both[both[:, 0] < -0.07]
        assert keys[:, 2].max() < screen[:, 2].max()
    shut = [sides(flip_shut(np.random.default_rng(seed))) for seed in SEEDS]
    assert max(length for *_, length in shut) < 0.14


def test_a_body_fills_its_box_but_for_rounded_corners_and_edges():
    mesh = body(0.12, 0.05, 0.02, 0.01, (0.004, 0.002))
    assert_closed_and_outward(mesh)
    np.testing.assert_allclose(mesh.bounds, [[-0.06, -0.025, 0], [0.06, 0.025, 0.02]], atol=1e-12)
    assert 0.9 < mesh.volume / (0.12 * 0.05 * 0.02) < 0.99


def test_a_lip_leaves_the_top_recessed_within_its_rim():
    mesh = body(0.12, 0.06, 0.012, 0.01, lip=0.002)
    assert_closed_and_outward(mesh)
    middle = mesh.vertices[np.hypot(*mesh.vertices.T[:2]) < 1e-9, 2]
    assert middle.max() == pytest.approx(0.010)
    assert mesh.bounds[1][2] == pytest.approx(0.012)


def test_keys_stay_in_their_field_and_apart():
    keys = keypad(0.04, 0.03, 4, 3, 0.001, fill=0.8)
    assert len(keys) == 12
    low, high = (np.array([key.bounds[i] for key in keys]) for i in (0, 1))
    np.testing.assert_allclose([low[:, :2].min(axis=0), high[:, :2].max(axis=0)], [[-0.019, -0.014], [0.019, 0.014]])
    np.testing.assert_allclose(high[:, 2], 0.001)


def test_a_phone_of_any_style_comes_from_the_generator():
    counts = {len(cell_phone.build(np.random.default_rng(seed)).triangles) for seed in range(30)}
    assert len(counts) >= 5
