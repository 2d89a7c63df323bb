"""The merged model: one point a cell, in frame {0}, without outliers."""

import numpy as np

from processing.reconstruction.model import ModelSettings, build_model, merge, remove_outliers
from processing.surface import Scale
from recorder import poses
from recorder.session import View
from tests.geometry import blob, random_pose


def view(index, points, colors=None):
    return View(index, f"v{index}", 1, points.astype(np.float32), colors)


def test_views_are_merged_where_their_poses_put_them():
    rng = np.random.default_rng(0)
    points, _ = blob(rng, 3000)
    T = random_pose(rng)
    views = [view(0, points), view(1, poses.transform(poses.invert(T), points)), view(2, points + 9)]
    merged = merge(views, {0: np.eye(4), 1: T}, 0.005)
    assert len(merged) < len(points)
    assert np.abs(merged).max() < 1


def test_colours_are_kept_where_all_views_have_them():
    rng = np.random.default_rng(0)
    points = rng.random((100, 3))
    red = np.tile(np.array([[200, 10, 10]], np.uint8), (100, 1))
    scale = Scale(0.01, 0.0, 1.0)
    colored = build_model([view(0, points, red)], {"icp": {0: np.eye(4)}}, scale, ModelSettings())
    assert (colored.colors == [200, 10, 10]).all()
    mixed = [view(0, points, red), view(1, points)]
    assert build_model(mixed, {"icp": {0: np.eye(4), 1: np.eye(4)}}, scale, ModelSettings()).colors is None


def test_stray_points_go_and_the_surface_stays():
    rng = np.random.default_rng(0)
    surface, _ = blob(rng, 5000)
    strays = np.array([[1.0, 1, 1], [-1, 1, 0.5], [0.5, -1, 1]])
    model = remove_outliers(np.vstack([surface, strays]), "pairwise", ModelSettings())
    assert {tuple(p) for p in strays.astype(np.float32)} <= {tuple(p) for p in model.removed}
    assert len(model.points) > 0.9 * len(surface)
    assert len(model.points) + len(model.removed) == len(surface) + 3


def test_the_best_method_makes_the_model_and_none_makes_none():
    points = np.random.default_rng(0).random((200, 3))
    scale = Scale(0.01, 0.0, 1.0)
    both = {"icp": {0: np.eye(4)}, "pairwise": {0: np.eye(4)}}
    assert build_model([view(0, points)], both, scale, ModelSettings()).method == "pairwise"
    assert build_model([view(0, points)], {"pairwise": {}}, scale, ModelSettings()) is None
    assert build_model([], {}, None, ModelSettings()) is None
