"""What a voxel grid keeps of a view, by hand-made grids; how one is drawn; the studies on two small objects."""

import numpy as np
import pytest
from matplotlib.colors import LogNorm

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import write
from orbitscan.processing.reproduction.views import circles, voxelization
from orbitscan.processing.reproduction.views.grid_drawing import draw_grid
from orbitscan.recorder.session import SessionInfo, View, in_memory


def make_session(category, points, colors=None):
    views = [View(i, f"view_{i}", i + 1, points.astype(np.float32), colors) for i in range(6)]
    return in_memory(SessionInfo(category, len(views), category, "1"), views)


def make_sphere(n, seed):
    directions = np.random.default_rng(seed).normal(size=(n, 3))
    return 0.05 * directions / np.linalg.norm(directions, axis=1, keepdims=True) + (0, 0, 1)


@pytest.fixture
def two_objects(monkeypatch):
    """A dense and a thin sphere for the ten categories."""
    views = {"coffee_mug": make_sphere(3000, 0), "dry_battery": make_sphere(60, 1)}
    found = {name: [make_session(name, points)] for name, points in views.items()}
    monkeypatch.setattr(circles, "open_instances", lambda plan: found)


def test_a_grid_counts_its_points_and_knows_how_far_they_lie_from_the_centres():
    points = np.array([(-1, 0, 0)] * 3 + [(1, 0, 0)] * 3, np.float32)  # r = 1, two voxels of side 1
    grid = voxelization.make_grid(points, 2)
    assert sorted(grid.occupied) == [3, 3]
    assert grid.side == pytest.approx(1)
    assert grid.shared == 1
    assert grid.offset == pytest.approx(np.sqrt(3) / 2)  # from a voxel's centre to its corner's edge


def test_points_alone_in_their_voxels_are_not_shared():
    points = np.array([(-1, 0, 0), (-1, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0)], np.float32)
    grid = voxelization.make_grid(points, 8)
    assert grid.counts.sum() == 5
    assert grid.shared == pytest.approx(1 / 4)


def test_the_entropy_of_a_grid():
    assert voxelization.measure_entropy(np.zeros((4, 4, 4))) == 0
    assert voxelization.measure_entropy(np.array([0, 0, 1, 1])) == pytest.approx(4)  # a bit each
    assert voxelization.measure_entropy(np.array([0, 0, 1, 2])) == pytest.approx(6)


def test_occupancy_has_fewer_bits_than_counts_and_the_text_says_by_how_much(tmp_path, two_objects):
    report = voxelization.show_values(Plan(tmp_path))
    rows = {(row["category"], row["voxels hold"]): row for row in report.rows}
    assert len(rows) == 4
    mug = rows["coffee_mug", "counts"]
    assert mug["points"] == 3000
    assert mug["largest_value"] > 1 == rows["coffee_mug", "occupancy"]["largest_value"]
    assert mug["entropy_bits"] > rows["coffee_mug", "occupancy"]["entropy_bits"]
    assert f"{mug['shared_percent']:.0f} %" in report.said[0]
    assert all(path.stat().st_size for path in write(report, Plan(tmp_path), "reproduce"))


def test_finer_grids_have_smaller_voxels_and_lose_less(tmp_path, two_objects):
    report = voxelization.show_resolutions(Plan(tmp_path))
    rows = [row for row in report.rows if row["category"] == "coffee_mug"]
    assert [row["div"] for row in rows] == [16, 24, 32]
    assert rows[0]["voxel_mm"] == pytest.approx(2 * rows[2]["voxel_mm"])
    assert rows[0]["offset_mm"] > rows[1]["offset_mm"] > rows[2]["offset_mm"]
    assert rows[0]["occupied_voxels"] < rows[1]["occupied_voxels"] < rows[2]["occupied_voxels"]
    assert set(report.figures) == {"figure-3.6"}


def draw(grid, norm=None):
    figure, ((axes,),) = charts.new_figure()
    faces = draw_grid(axes, grid, norm)
    figure.canvas.draw()
    return faces


def test_faces_between_voxels_are_not_drawn():
    grid = np.zeros((4, 4, 4))
    grid[1, 1, 1] = 1
    assert len(draw(grid).get_paths()) == 3
    grid[1, 1, 2] = 1
    assert len(draw(grid).get_paths()) == 5
    assert len(draw(np.ones((4, 4, 4))).get_paths()) == 3 * 16


def test_what_is_near_covers_what_is_far_and_each_face_has_its_voxels_count():
    grid = np.zeros((4, 4, 4))
    grid[0, 3, 3], grid[3, 0, 0] = 2, 7  # far and near for a viewer above, beside the camera (y down, z forward)
    grid[0, 0, 0], grid[3, 3, 3] = 4, 5
    values = draw(grid, LogNorm(1, 7)).get_array()
    assert len(values) == 12
    assert list(values).index(4) > list(values).index(5)  # z forward: what is at 0 is near


def test_a_whole_grid_fits_its_axes():
    _, ((axes,),) = charts.new_figure()
    faces = draw_grid(axes, np.ones((3, 3, 3)))
    places = np.concatenate([path.vertices for path in faces.get_paths()])
    assert np.abs(places).max() < axes.get_xlim()[1]
    assert np.abs(places).max() > 0.7 * axes.get_xlim()[1]
