"""Whitening and first filters: covariance, rotation, variance, and what is left out."""

import numpy as np
import pytest
import torch

from orbitscan.processing.classification.initialization.kmeans import (
    KMeansSettings,
    collect,
    cut,
    first_filters,
    normalize,
    patches,
    set_first_filters,
    whiten,
)
from orbitscan.processing.classification.network import BODY, Network
from orbitscan.processing.classification.voxels import VoxelSettings, bounding_spheres, pack, voxel_grids, voxel_indices
from orbitscan.processing.features.keypoints import detect_keypoints
from orbitscan.recorder.exceptions import InvalidOption

VOXELS = VoxelSettings()
KEYPOINTS = KMeansSettings().keypoints


def shell(seed, points=4000):
    """A view of a bumpy object: the near half of a sphere with waves on it."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(points, 3))
    directions[:, 2] = -np.abs(directions[:, 2])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    waves = 1 + 0.15 * np.sin(directions @ rng.normal(size=(3, 3)) * 6).sum(axis=1, keepdims=True)
    return (0.1 * waves * directions + [0, 0, 1]).astype(np.float32)


@pytest.fixture(scope="module")
def views():
    return [shell(seed) for seed in range(8)]


@pytest.fixture(scope="module")
def found(views):
    return collect(views, 3, VOXELS, KMeansSettings(), 0)


def grid_of(points, settings=VOXELS):
    return voxel_grids(pack([points]), settings)[0, 0].numpy()


def test_patches_have_no_mean_and_a_deviation_of_one(found):
    assert found.shape[1] == 27
    assert len(found) > 100
    assert found.mean(axis=1) == pytest.approx(0, abs=1e-12)
    assert found.std(axis=1) == pytest.approx(1)


def test_a_patch_is_cut_about_its_voxel_and_zero_beyond_the_border():
    grid = np.arange(1.0, 126).reshape(5, 5, 5)
    inside, corner = cut(grid, np.array([[2, 2, 3], [4, 0, 2]]), 3).reshape(2, 3, 3, 3)
    assert np.array_equal(inside, grid[1:4, 1:4, 2:5])
    assert np.array_equal(corner[:2, 1:], grid[3:5, 0:2, 1:4])
    assert not corner[2].any()
    assert not corner[:, 0].any()
    assert cut(grid, np.array([[2, 2, 2]]), 2).tolist() == [grid[1:3, 1:3, 1:3].ravel().tolist()]


def test_constant_patches_are_left_out():
    assert normalize(np.array([[3.0, 3, 3, 3], [0, 0, 0, 2], [0, 0, 0, 0]])) == pytest.approx(
        np.array([[-1, -1, -1, 3]]) / np.sqrt(3)
    )


def test_patches_lie_about_keypoints(views):
    unit = 2 * float(bounding_spheres(pack(views[:1]))[1][0]) / 32
    keypoints = detect_keypoints(views[0], 2.5 * unit, unit, KEYPOINTS)
    voxels = np.unique(voxel_indices(pack(views[:1]), 32).numpy()[keypoints], axis=0)
    found = patches(views[0], grid_of(views[0]), 5, KEYPOINTS)
    assert len(found) == len(voxels) > 10
    grid = grid_of(views[0])
    middles = found[:, 62] * [w.std() for w in cut(grid, voxels, 5)] + [w.mean() for w in cut(grid, voxels, 5)]
    assert middles == pytest.approx(grid[tuple(voxels.T)])
    assert middles.min() > 1 - 1e-9  # a keypoint is a point


def test_no_patches_of_a_view_without_extent():
    point = np.zeros((3, 3), np.float32)
    assert patches(point, grid_of(point), 5, KEYPOINTS).shape == (0, 125)


@pytest.mark.parametrize("kind", ["pca", "zca"])
def test_whitened_patches_have_unit_covariance_on_the_kept_eigenvalues(found, kind):
    whitening = whiten(found, kind)
    assert whitening.kept == 26  # a patch without its mean is orthogonal to the constant one
    white = whitening.apply(found)
    assert white.mean(axis=0) == pytest.approx(0, abs=1e-9)
    covariance = white.T @ white / len(white)
    if kind == "zca":  # symmetric: the directions are the patches' own
        _, P = np.linalg.eigh(np.cov(found.T, bias=True))
        covariance = P[:, ::-1].T @ covariance @ P[:, ::-1]
    assert covariance == pytest.approx(np.diag([1.0] * 26 + [0.0]), abs=1e-8)


def test_zca_is_pca_turned_back(found):
    pca, zca = whiten(found, "pca"), whiten(found, "zca")
    assert zca.matrix == pytest.approx(zca.matrix.T)
    assert zca.matrix.T @ zca.matrix == pytest.approx(pca.matrix.T @ pca.matrix)
    lengths = [np.linalg.norm(w.apply(found), axis=1) for w in (pca, zca)]
    assert lengths[0] == pytest.approx(lengths[1])


def test_weak_directions_are_mapped_to_zero():
    rng = np.random.default_rng(0)
    samples = rng.normal(size=(2000, 3)) * [1, 0.01, 1e-4]  # variances 1, 1e-4, 1e-8
    assert whiten(samples, "pca").kept == 2
    assert whiten(samples, "pca", floor=1e-10).kept == 3
    assert np.abs(whiten(samples, "pca").apply(samples)[:, 2]).max() == 0


@pytest.mark.parametrize("back_project", [False, True])
def test_each_filter_has_glorots_variance(views, back_project):
    settings = KMeansSettings(back_project=back_project)
    filters = first_filters(views, 8, 5, VOXELS, settings, 0)
    assert filters.shape == (8, 1, 5, 5, 5)
    assert filters.dtype == torch.float32
    variance = 2 / (1 * 125 + 8 * 125)
    assert filters.square().mean(dim=(1, 2, 3, 4)).tolist() == pytest.approx([variance] * 8, rel=1e-5)
    assert len(np.unique(filters.numpy().round(6), axis=0)) == 8


def test_led_back_to_voxels_pca_and_zca_find_the_same_filters(views):
    found = [
        first_filters(views, 4, 3, VOXELS, KMeansSettings(kind, back_project=True), 0).numpy().reshape(4, -1)
        for kind in ("pca", "zca")
    ]
    similarity = found[0] @ found[1].T / np.sqrt((found[0] ** 2).sum(1)[:, None] * (found[1] ** 2).sum(1))
    assert similarity.max(axis=1) == pytest.approx(1, abs=1e-3)
    assert found[0].mean(axis=1) == pytest.approx(0, abs=1e-6)


def test_the_same_seed_gives_the_same_filters(views):
    once, again, other = (first_filters(views, 4, 3, VOXELS, KMeansSettings(), seed) for seed in (0, 0, 1))
    assert torch.equal(once, again)
    assert not torch.equal(once, other)


def test_no_more_patches_than_asked_for(views):
    assert len(collect(views, 3, VOXELS, KMeansSettings(at_most=70), 0)) == 70


def test_only_the_first_convolution_is_replaced(views):
    torch.manual_seed(0)
    network = Network(f"{BODY}-FC(10)", 10)
    before = {name: value.clone() for name, value in network.state_dict().items()}
    set_first_filters(network, views, VOXELS, KMeansSettings(), 0)
    changed = {name for name, value in network.state_dict().items() if not torch.equal(value, before[name])}
    assert changed == {"features.0.weight"}
    assert torch.equal(network.convolutions[0].weight, first_filters(views, 32, 5, VOXELS, KMeansSettings(), 0))


def test_too_few_patches_are_told(views):
    with pytest.raises(InvalidOption, match="different patches about keypoints for 500 filters"):
        first_filters(views[:1], 500, 3, VOXELS, KMeansSettings(), 0)
    with pytest.raises(InvalidOption, match="0 different patches"):
        first_filters([], 4, 3, VOXELS, KMeansSettings(), 0)


def test_a_network_without_convolution_is_told(views):
    with pytest.raises(InvalidOption, match="no convolution"):
        set_first_filters(Network("P(4)-FC(10)", 10), views, VOXELS, KMeansSettings(), 0)
