"""The grid of cells finds what a tree finds, and its means are those of its cells."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from orbitscan.processing.kernels.grid import build, cell_means, rows_around


def test_rows_hold_every_neighbour_within_a_cell():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(2000, 3))
    grid = build(points, 0.3)
    tree = cKDTree(points)
    rows = np.empty((9, 2), np.int64)
    for point in points[:50]:
        rows_around(grid, point, rows)
        candidates = {int(i) for start, stop in rows for i in grid.order[start:stop]}
        assert set(tree.query_ball_point(point, 0.3)) <= candidates


def test_a_far_stray_point_does_not_spoil_the_cells():
    points = np.vstack([np.random.default_rng(1).random((500, 3)), [[1e6, 0, 0]]])
    grid = build(points, 0.1)
    columns = grid.columns
    assert sorted(grid.order) == list(range(501))
    assert columns[..., 0].size <= 1 << 20
    near = points[:500]
    rows = np.empty((9, 2), np.int64)
    for point in near[:20]:
        rows_around(grid, point, rows)
        found = {int(i) for start, stop in rows for i in grid.order[start:stop]}
        assert set(cKDTree(points).query_ball_point(point, 0.1)) <= found
        assert len(found) < 250


@pytest.mark.parametrize("stray", [[1e4, 0, 0], [-1e4, 1e4, 0], [0, 0, -1e4]])
def test_strays_beyond_the_columns_are_found_too(stray):
    points = np.vstack([np.random.default_rng(1).random((500, 3)), [stray, np.array(stray) + 0.05]])
    grid = build(points, 0.1)
    rows = np.empty((9, 2), np.int64)
    rows_around(grid, points[500], rows)
    found = {int(i) for start, stop in rows for i in grid.order[start:stop]}
    assert {500, 501} <= found


def test_cell_means_average_points_and_attributes():
    points = np.array([[0.01, 0.01, 0.01], [0.03, 0.01, 0.01], [0.95, 0.0, 0.0]])
    colors = np.array([[0, 10, 20], [100, 30, 20], [7, 8, 9]])
    rows = cell_means(points, 0.5, colors)
    assert np.allclose(rows, [[0.02, 0.01, 0.01, 50, 20, 20], [0.95, 0, 0, 7, 8, 9]])


def test_cell_means_of_nothing_is_nothing():
    assert cell_means(np.empty((0, 3)), 0.1).shape == (0, 3)
    assert cell_means(np.empty((0, 3)), 0.1, np.empty((0, 3))).shape == (0, 6)
