"""The grid of a view against the thesis's formulas, written out in numpy."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.processing.classification.voxels import VoxelSettings, bounding_spheres, pack, voxel_grids, voxel_indices


def cloud(seed, points=500, size=0.1, place=(0.02, -0.1, 1.0)):
    return (np.random.default_rng(seed).normal(size=(points, 3)) * size + place).astype(np.float32)


def reference(points, div):
    """(3.18) to (3.22) as they stand, in double precision: indices before they are cut to integers."""
    centroid = points.mean(axis=0)
    r = np.linalg.norm(points - centroid, axis=1).max()
    return (points - (centroid - r)) / (2 * r / div)


@given(seed=st.integers(0, 2**32 - 1), points=st.integers(2, 400), div=st.sampled_from([1, 7, 16, 24, 32]))
def test_the_voxel_of_a_point_is_the_formulas(seed, points, div):
    view = cloud(seed, points)
    expected = reference(view.astype(np.float64), div)
    found = voxel_indices(pack([view]), div).numpy()
    near_a_face = np.abs(expected - np.round(expected)) < 1e-4
    assert np.array_equal(found[~near_a_face], np.floor(expected[~near_a_face]).astype(int))
    assert found.min() >= 0
    assert found.max() <= div - 1


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_point_at_the_spheres_edge_is_in_the_last_voxel(axis):
    ends = np.zeros((2, 3), np.float32)
    ends[:, axis] = 0.75, -0.75
    indices = voxel_indices(pack([ends]), 32).numpy()
    assert indices[0].tolist() == [31 if i == axis else 16 for i in range(3)]
    assert indices[1].tolist() == [0 if i == axis else 16 for i in range(3)]


@given(seed=st.integers(0, 2**32 - 1))
def test_no_point_lies_beyond_the_sphere_and_one_lies_on_it(seed):
    view = cloud(seed)
    centroids, radii = bounding_spheres(pack([view]))
    distances = np.linalg.norm(view - centroids[0].numpy(), axis=1)
    assert distances.max() == pytest.approx(float(radii[0]), rel=1e-5)
    assert centroids[0].numpy() == pytest.approx(view.astype(np.float64).mean(axis=0), abs=1e-6)


@given(lengths=st.lists(st.integers(1, 300), min_size=1, max_size=5), div=st.sampled_from([8, 32]))
def test_counts_sum_to_the_points_of_each_view(lengths, div):
    views = [cloud(i, length) for i, length in enumerate(lengths)]
    grids = voxel_grids(pack(views), VoxelSettings(div))
    assert grids.shape == (len(views), 1, div, div, div)
    assert grids.sum(dim=(1, 2, 3, 4)).tolist() == lengths


def test_a_voxel_holds_the_points_that_fall_into_it():
    view = cloud(3)
    found = voxel_grids(pack([view]), VoxelSettings(16))[0, 0].numpy()
    expected = np.zeros((16, 16, 16))
    np.add.at(expected, tuple(voxel_indices(pack([view]), 16).numpy().T), 1)
    assert np.array_equal(found, expected)
    assert found.max() > 1


def test_a_view_has_the_same_grid_alone_and_among_others():
    views = [cloud(i, 50 + 90 * i) for i in range(4)]
    together = voxel_grids(pack(views))
    for view, grid in zip(views, together, strict=True):
        assert torch.equal(voxel_grids(pack([view]))[0], grid)


@given(scale=st.sampled_from([0.25, 0.5, 2.0, 1024.0]))
def test_a_grid_does_not_tell_the_size(scale):
    view = cloud(5)
    assert torch.equal(voxel_grids(pack([view])), voxel_grids(pack([view * np.float32(scale)])))


def test_occupancy_is_where_there_are_counts():
    view = pack([cloud(6)])
    occupancy = voxel_grids(view, VoxelSettings(16, "occupancy"))
    assert torch.equal(occupancy > 0, voxel_grids(view, VoxelSettings(16)) > 0)
    assert set(occupancy.unique().tolist()) == {0.0, 1.0}


def test_density_does_not_tell_how_often_each_point_was_measured():
    view = cloud(7)
    once, thrice = pack([view]), pack([np.repeat(view, 3, axis=0)])
    density = VoxelSettings(values="density")
    torch.testing.assert_close(voxel_grids(once, density), voxel_grids(thrice, density))
    assert not torch.equal(voxel_grids(once), voxel_grids(thrice))
    grid = voxel_grids(once, density)
    assert float(grid[grid > 0].mean()) == pytest.approx(1)


def test_a_weight_stands_for_so_many_points_at_one_place():
    view = cloud(8)
    weighted = pack([view])
    weighted = type(weighted)(weighted.points, weighted.lengths, torch.full((len(view),), 3.0))
    assert torch.equal(voxel_grids(weighted), voxel_grids(pack([np.repeat(view, 3, axis=0)])))


def test_a_view_without_extent_lies_in_the_middle():
    grids = voxel_grids(pack([np.ones((5, 3), np.float32), np.ones((1, 3), np.float32)]))
    assert grids[:, 0, 16, 16, 16].tolist() == [5, 1]
