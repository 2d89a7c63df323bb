"""What lamps do to colours: smooth shading is fitted and removed, highlights are found, paint is left."""

import numpy as np
import pytest

from orbitscan.processing.surface.lighting import find_highlights, light_basis, project, remove_light


@pytest.fixture
def normals():
    n = np.random.default_rng(0).normal(size=(4000, 3))
    n[:, 2] = np.abs(n[:, 2])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def shade(normals, lamp, ambient=0.6):
    """The logarithm of Lambert's brightness under a lamp (3,), some of it from everywhere."""
    return np.log(ambient + (1 - ambient) * np.clip(normals @ lamp, 0, 1))


@pytest.mark.parametrize("lamp", [(0, 0, 1), (0.6, 0, 0.8), (0.8, -0.6, 0)])
def test_diffuse_light_from_any_side_leaves_little(normals, lamp):
    brightness = shade(normals, np.array(lamp))
    left, _ = remove_light(brightness[:, None], np.full((4000, 1), 1e-4), light_basis(normals))
    assert np.quantile(np.abs(left), 0.99) < 0.06 < np.ptp(brightness) / 4


def test_paint_is_left_where_light_is_removed(normals):
    paint = np.where(np.random.default_rng(1).random(4000) < 0.3, -0.5, 0.0)
    brightness = paint + shade(normals, np.array([0.6, 0, 0.8]))
    left, weights = remove_light(brightness[:, None], np.full((4000, 1), 1e-3), light_basis(normals))
    assert np.corrcoef(left[:, 0], paint)[0, 1] > 0.95
    assert weights[paint < 0].mean() < 0.5 * weights[paint == 0].mean()


def test_a_highlight_is_found_and_dark_paint_is_none(normals):
    mirrored = np.exp(-(np.arccos(normals[:, 2].clip(-1, 1)) ** 2) / (2 * np.radians(8) ** 2))
    brightness = shade(normals, np.array([0, 0, 1.0])) + 0.4 * mirrored
    dark = np.random.default_rng(2).random(4000) < 0.1
    found = find_highlights(brightness - 0.5 * dark, np.full(4000, 1e-4), light_basis(normals))
    assert found[(mirrored > 0.6) & ~dark].mean() > 0.95
    assert not found[dark].any()
    assert found[mirrored < 0.02].mean() < 0.02


def test_what_the_basis_spans_is_projected_wholly(normals):
    basis = light_basis(normals)
    column = (basis @ np.arange(1.0, basis.shape[1] + 1))[:, None]
    assert np.std(project(basis, np.ones(4000), column) - column) < 0.02 * np.std(column)
    assert project(basis[:0], np.ones(0), column[:0]).shape == (0, 1)
