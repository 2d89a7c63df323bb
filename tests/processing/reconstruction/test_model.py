"""The merged model: one point a cell, in frame {0}, without outliers."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.reconstruction.mesh import MeshSettings
from orbitscan.processing.reconstruction.model import ModelSettings, build_model, find_inliers, merge
from orbitscan.processing.surface.preparation import Scale
from orbitscan.recorder import poses
from orbitscan.recorder.session import View
from tests.geometry import blob, random_pose, sphere

SCALE = Scale(working=0.01, patch=0.03, noise=0.0, diameter=1.0)
AT_ORIGIN = (0.0, 0.0, 0.0)


def view(index, points, colors=None):
    return View(index, f"v{index}", 1, points.astype(np.float32), colors)


def test_views_are_merged_where_their_poses_put_them():
    rng = np.random.default_rng(0)
    points, _ = blob(rng, 3000)
    T = random_pose(rng)
    views = [view(0, points), view(1, poses.transform(poses.invert(T), points)), view(2, points + 9)]
    merged = merge(views, {0: np.eye(4), 1: T}, AT_ORIGIN, 0.005)
    assert len(merged) < len(points)
    assert np.abs(merged[:, :3]).max() < 1


@pytest.mark.parametrize("origin", [AT_ORIGIN, (0.0, 0.0, -3.0)])
def test_points_know_from_where_they_were_seen(origin):
    rng = np.random.default_rng(0)
    points, T = rng.random((300, 3)) + np.array([0, 0, 2]), random_pose(rng)
    merged = merge([view(0, points)], {0: T}, origin, 1e-6)
    sensor = poses.transform(T, np.array([origin]))[0]
    expected = sensor - merged[:, :3]
    expected /= np.linalg.norm(expected, axis=1, keepdims=True)
    assert np.allclose(merged[:, 3:6], expected, atol=1e-4)
    outward = merge([view(0, points)], {0: T}, None, 1e-6)
    middle = poses.transform(T, points.mean(axis=0)[None])
    assert (np.einsum("ni,ni->n", outward[:, 3:6], outward[:, :3] - middle) > 0).all()


def test_colours_are_kept_where_all_views_have_them():
    rng = np.random.default_rng(0)
    points = rng.random((100, 3))
    red = np.tile(np.array([[200, 10, 10]], np.uint8), (100, 1))
    colored = build_model([view(0, points, red)], {0: np.eye(4)}, "icp", SCALE, AT_ORIGIN, ModelSettings())
    assert (colored.colors == [200, 10, 10]).all()
    mixed = [view(0, points, red), view(1, points)]
    both = {0: np.eye(4), 1: np.eye(4)}
    assert build_model(mixed, both, "icp", SCALE, AT_ORIGIN, ModelSettings()).colors is None


def test_stray_points_go_and_the_surface_stays():
    surface, _ = blob(np.random.default_rng(0), 5000)
    strays = np.array([[1.0, 1, 1], [-1, 1, 0.5], [0.5, -1, 1]])
    everything = np.vstack([surface, strays])
    kept = find_inliers(everything, ModelSettings())
    assert not kept[-3:].any()
    assert kept[:-3].mean() > 0.9
    model = build_model([view(0, everything)], {0: np.eye(4)}, "pairwise", SCALE, AT_ORIGIN, ModelSettings())
    assert {tuple(p) for p in strays.astype(np.float32)} <= {tuple(p) for p in model.removed}
    assert len(model.points) > 0.9 * len(merge([view(0, everything)], {0: np.eye(4)}, AT_ORIGIN, SCALE.working))


def test_a_model_names_its_method_and_nothing_makes_none():
    points = np.random.default_rng(0).random((200, 3))
    model = build_model([view(0, points)], {0: np.eye(4)}, "pairwise", SCALE, AT_ORIGIN, ModelSettings())
    assert model.method == "pairwise"
    assert model.mesh is None
    assert build_model([view(0, points)], {}, "pairwise", SCALE, AT_ORIGIN, ModelSettings()) is None
    assert build_model([view(0, points)], {0: np.eye(4)}, None, SCALE, AT_ORIGIN, ModelSettings()) is None
    assert build_model([], {}, "icp", None, AT_ORIGIN, ModelSettings()) is None


def test_few_points_have_no_outliers():
    assert find_inliers(np.random.default_rng(0).random((5, 3)), ModelSettings()).all()
    assert find_inliers(np.empty((0, 3)), ModelSettings()).shape == (0,)


@pytest.mark.usefixtures("open3d")
def test_the_mesh_lies_on_the_surface_faces_outwards_and_has_no_lid_where_nothing_was_seen():
    """Four views of a sphere from all sides, and of its lower part none."""
    on, out = sphere(np.random.default_rng(0), 30_000)
    on, out = on[on[:, 2] > -0.05], out[on[:, 2] > -0.05]
    red = np.tile(np.array([[200, 10, 10]], np.uint8), (len(on), 1))
    eyes = [(1.0, 0, 0), (0, 1.0, 0), (-1.0, 0, 0), (0, -1.0, 0)]
    T_0 = {i: poses.make(np.eye(3), eye) for i, eye in enumerate(eyes)}
    seen = [np.einsum("ni,ni->n", out, np.array(eye) - on) > 0.1 for eye in eyes]
    views = [view(i, poses.transform(poses.invert(T_0[i]), on[side]), red[side]) for i, side in enumerate(seen)]
    scale = replace(SCALE, working=0.005)
    wanted = ModelSettings(mesh=MeshSettings(wanted=True))
    mesh = build_model(views, T_0, "refined", scale, AT_ORIGIN, wanted).mesh
    assert np.abs(np.linalg.norm(mesh.vertices, axis=1) - 0.1).max() < 0.005
    a, b, c = (mesh.vertices[mesh.triangles[:, k]] for k in range(3))
    normals, middles = np.cross(b - a, c - a), (a + b + c) / 3
    assert (np.einsum("ti,ti->t", normals, middles) > 0).mean() > 0.99
    assert mesh.vertices[:, 2].min() > -0.07
    assert mesh.triangles.max() == len(mesh.vertices) - 1
    assert (mesh.colors == [200, 10, 10]).all()
