"""Our own raycaster: geometry that is known, and what Open3D's says of the same rays."""

import sys

import numpy as np
import pytest

from orbitscan.recorder import mcap_file
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.box_tree import BoxTree
from orbitscan.recorder.simulation.camera import simulate
from orbitscan.recorder.simulation.objects.solids import box

THESIS = ("bin", "statue", "helicopter", "robot", "vacuum_cleaner")


@pytest.fixture
def without_open3d(monkeypatch):
    monkeypatch.setitem(sys.modules, "open3d", None)


def test_rays_meet_the_nearer_side_of_a_box_where_they_point():
    tree = BoxTree(box(0.4, 0.4, 0.2).moved(z=1))
    hits = tree.cast(np.zeros(3), np.array([[0.01, 0.02, 1], [0, 0, 2], [0, 0, -1], [1, 0, 0], [0.3, 0, 1]]), 1)
    np.testing.assert_allclose(hits.distance, [1, 0.5, np.inf, np.inf, np.inf])
    np.testing.assert_allclose(np.abs(hits.normals[:2]), [[0, 0, 1], [0, 0, 1]])


def test_no_ray_slips_between_triangles():
    mesh = box(0.4, 0.4, 0.2).moved(z=1)
    x, y = np.meshgrid(np.linspace(-0.19, 0.19, 129), np.linspace(-0.19, 0.19, 129))  # diagonals and all
    rays = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
    np.testing.assert_allclose(BoxTree(mesh).cast(np.zeros(3), rays, 1).distance, 1, atol=1e-7)


@pytest.mark.parametrize("name", ["robot", "coffee_mug"])
def test_the_place_on_the_triangle_is_the_place_on_the_ray(name):
    mesh = objects.build(name)
    rng = np.random.default_rng(0)
    origin = mesh.bounds[1] + 0.3
    rays = (rng.uniform(*mesh.bounds, size=(2000, 3)) - origin).astype(np.float32)
    hits = BoxTree(mesh).cast(origin, rays, 2)
    met = np.isfinite(hits.distance)
    assert met.mean() > 0.3
    corners = mesh.vertices[mesh.triangles[hits.triangles[met]]]
    weights = np.column_stack([1 - hits.uv[met].sum(axis=1), hits.uv[met]])
    on_triangle = (weights[:, :, None] * corners).sum(axis=1)
    np.testing.assert_allclose(on_triangle, origin + hits.distance[met, None] * rays[met], atol=1e-6)


def test_a_triangle_without_area_and_many_at_one_place_are_no_trouble():
    corners = np.array([[0, 0, 1], [1, 0, 1], [0, 1, 1], [0, 0, 1]], float)
    mesh = Mesh(corners, np.array([[0, 1, 2]] * 50 + [[0, 3, 0]] * 20))
    hits = BoxTree(mesh).cast(np.zeros(3), np.array([[0.2, 0.2, 1.0]]), 1)
    assert hits.distance == pytest.approx([1])


@pytest.mark.parametrize("name", THESIS)
def test_depths_are_open3ds_within_a_micrometre(name, open3d, monkeypatch):
    theirs = simulate(name, views=5, noise_mm=0)
    monkeypatch.setitem(sys.modules, "open3d", None)
    ours = simulate(name, views=5, noise_mm=0)
    assert theirs.info.sensor == f"virtual depth camera, rays cast by Open3D {open3d.__version__}"
    assert ours.info.sensor == "virtual depth camera, rays cast by orbitscan"
    for view, other in zip(ours.views(), theirs.views(), strict=True):
        np.testing.assert_allclose(view.points, other.points, rtol=0, atol=1e-6)
        assert (view.colors == other.colors).all(axis=1).mean() > 0.999


@pytest.mark.usefixtures("without_open3d")
def test_without_open3d_a_recording_says_who_cast_the_rays(tmp_path):
    mcap_file.write(simulate("bowl", views=2, sensor="kinect"), tmp_path / "bowl.mcap")
    recorded = mcap_file.read(tmp_path / "bowl.mcap")
    assert recorded.info.sensor == "virtual Kinect (0.72 m, 570 pixels, 1 mm, seed 0), rays cast by orbitscan"
    assert all(len(view.points) > 500 for view in recorded.views())


@pytest.mark.usefixtures("without_open3d")
def test_the_number_of_threads_changes_no_bit():
    one, four = (simulate("robot", views=2, threads=threads).load(1) for threads in (1, 4))
    np.testing.assert_array_equal(one.points, four.points)
