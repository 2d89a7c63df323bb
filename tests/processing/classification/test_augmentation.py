"""Variations vary what they say, and nothing else."""

import numpy as np
import pytest
import torch

from orbitscan.processing.classification.augmentation import AugmentationSettings, augment, rotations
from orbitscan.processing.classification.labelled_views import gather
from orbitscan.processing.classification.voxels import Clouds, bounding_spheres
from tests.processing.classification import toys

ROWS = np.arange(12)


@pytest.fixture(scope="module")
def views():
    return gather(toys.sessions())


def varied(views, seed=0, up=None, **settings):
    up = torch.from_numpy(views.up[ROWS]) if up is None else up
    generator = torch.Generator().manual_seed(seed)
    return augment(views.clouds(ROWS), up, AugmentationSettings(**settings), generator)


def test_nothing_asked_for_is_nothing_changed(views):
    assert torch.equal(varied(views).points, views.clouds(ROWS).points)


def test_rotations_are_rotations_by_the_right_hand():
    axes = torch.nn.functional.normalize(torch.randn(50, 3, generator=torch.Generator().manual_seed(0)), dim=1)
    R = rotations(axes, torch.linspace(-3, 3, 50))
    torch.testing.assert_close(R @ R.transpose(1, 2), torch.eye(3).expand(50, 3, 3), atol=1e-5, rtol=0)
    torch.testing.assert_close((R @ axes[:, :, None])[:, :, 0], axes, atol=1e-5, rtol=0)
    quarter = rotations(torch.tensor([[0.0, 0, 1]]), torch.tensor([torch.pi / 2]))
    torch.testing.assert_close(quarter[0] @ torch.tensor([1.0, 0, 0]), torch.tensor([0.0, 1, 0]), atol=1e-6, rtol=0)


@pytest.mark.parametrize("elevation", [-60.0, -20.0, 0.0, 30.0, 60.0, 90.0])
def test_a_view_turned_upright_has_its_vertical_along_the_image(elevation):
    views = gather([toys.session("stick", 1, views=12, elevation=elevation)])
    upright = varied(views, level=1.0)
    before = views.clouds(ROWS)
    heights = (before.points * torch.from_numpy(views.up[ROWS])[before.view]).sum(dim=1)
    torch.testing.assert_close(-upright.points[:, 1], heights, atol=2e-3, rtol=0)


def test_a_turn_keeps_every_points_height(views):
    before, after = views.clouds(ROWS), varied(views, turn_deg=180)
    up = torch.from_numpy(views.up[ROWS])[before.view]
    torch.testing.assert_close((after.points * up).sum(1), (before.points * up).sum(1), atol=2e-3, rtol=0)
    assert (after.points - before.points).norm(dim=1).max() > 0.5


def test_the_table_takes_the_lowest_points(views):
    before, after = views.clouds(ROWS), varied(views, crop=0.4)
    up = torch.from_numpy(views.up)
    for row in ROWS:
        heights = (before.points[before.view == row] @ up[row]).sort().values
        lost = len(heights) - int(after.lengths[row])
        assert 0 <= lost < len(heights)
        kept = (after.points[after.view == row] @ up[row]).sort().values
        spread = (heights[-1] - heights[lost]) / (kept[-1] - kept[0])  # the view is scaled to radius 1 again
        torch.testing.assert_close((kept - kept[0]) * spread, heights[lost:] - heights[lost], atol=1e-3, rtol=0)
    assert after.lengths.sum() < before.lengths.sum()


def test_thinned_views_are_centred_and_of_radius_one(views):
    after = varied(views, thin=0.9, occlusion=0.5, crop=0.3)
    centroids, radii = bounding_spheres(after)
    assert centroids.abs().max() < 1e-5
    torch.testing.assert_close(radii, torch.ones(len(ROWS)), atol=1e-5, rtol=0)
    assert (after.lengths >= 16).all()
    assert after.lengths.sum() < len(views.clouds(ROWS).points)


def test_strays_stand_off_the_surface(views):
    before, after = views.clouds(ROWS), varied(views, strays=1.0)
    moved = (after.points - before.points).norm(dim=1) > 1e-3
    assert 0 < moved.float().mean() < 0.05
    assert (after.points[moved].norm(dim=1) > before.points[moved].norm(dim=1)).all()


def test_the_seed_decides(views):
    everything = {"turn_deg": 90, "tilt_deg": 10, "stretch": 0.1, "crop": 0.1, "thin": 0.3, "noise": 0.02}
    assert torch.equal(varied(views, 1, **everything).points, varied(views, 1, **everything).points)
    assert len(varied(views, 1, **everything).points) != len(varied(views, 2, **everything).points)


def test_an_unknown_vertical_is_that_of_a_camera_looking_down_by_45_degrees(views):
    unknown = torch.full((len(ROWS), 3), torch.nan)
    torch.testing.assert_close(varied(views, turn_deg=90, up=unknown).points, varied(views, turn_deg=90).points)


def test_every_setting_moves_or_takes_points_and_its_zero_does_not(views):
    before = views.clouds(ROWS).points
    for name in AugmentationSettings.__dataclass_fields__:
        after = varied(views, **{name: 1.0}).points
        assert after.shape != before.shape or (after - before).abs().max() > 1e-3, name
        assert torch.equal(varied(views, **{name: 0.0}).points, before), name


def test_a_tilt_is_about_x_and_a_roll_about_z(views):
    before = views.clouds(ROWS).points
    for settings, axis in (({"tilt_deg": 40}, 0), ({"roll_deg": 40}, 2)):
        after = varied(views, **settings).points
        torch.testing.assert_close(after[:, axis], before[:, axis], atol=2e-3, rtol=0)
        torch.testing.assert_close(after.norm(dim=1), before.norm(dim=1), atol=2e-3, rtol=0)


def test_a_turn_is_to_either_side_and_no_more_than_asked_for(views):
    before, after = views.clouds(ROWS), varied(views, turn_deg=30)
    up = torch.from_numpy(views.up[ROWS])
    angles = []
    for row in ROWS:
        flat = [
            cloud.points[before.view == row] - (cloud.points[before.view == row] @ up[row])[:, None] * up[row]
            for cloud in (before, after)
        ]
        sine = (torch.linalg.cross(*flat, dim=1) @ up[row]).sum()
        angles.append(torch.atan2(sine, (flat[0] * flat[1]).sum()).rad2deg())
    assert -30.1 < min(angles) < 0 < max(angles) < 30.1


def test_a_stretch_is_of_each_axis_by_no_more_than_asked_for(views):
    before, after = views.clouds(ROWS).points, varied(views, stretch=0.2).points
    ratio = (after / before)[before.abs().min(dim=1).values > 0.05]
    assert 0.78 < ratio.min() < 0.9
    assert 1.1 < ratio.max() < 1.22


def test_noise_has_at_most_the_deviation_asked_for(views):
    before, after = views.clouds(ROWS), varied(views, noise=0.1)
    moved = after.points - before.points
    deviations = torch.stack([moved[before.view == row].std() for row in ROWS])
    assert deviations.max() < 0.11
    assert deviations.max() > 2 * deviations.min()  # drawn for every view


def test_something_before_a_view_hides_one_side_of_it(views):
    before = views.clouds(ROWS)
    lost = before.lengths - varied(views, occlusion=0.5).lengths
    assert 0 < (lost > 0).sum() < len(ROWS)  # of every other view, or so
    assert (lost < before.lengths / 2 + 20).all()


@pytest.mark.parametrize("points", [16, 17, 40])
def test_a_view_of_few_points_is_never_emptied(points):
    shown = torch.randn(20 * points, 3, generator=torch.Generator().manual_seed(1))
    clouds = Clouds(shown, torch.full((20,), points), torch.arange(20.0).repeat_interleave(points))
    settings = AugmentationSettings(crop=0.95, occlusion=0.95, thin=0.99)
    for seed in range(5):
        after = augment(clouds, torch.full((20, 3), torch.nan), settings, torch.Generator().manual_seed(seed))
        assert (after.lengths >= 16).all()
        assert after.points.isfinite().all()
        assert torch.equal(after.weights, torch.arange(20.0).repeat_interleave(after.lengths))  # go with their points


def test_a_view_without_extent_stays_finite():
    clouds = Clouds(torch.ones(30, 3), torch.tensor([30]))
    everything = AugmentationSettings(90, 10, 10, 1.0, 0.1, 0.2, 0.2, 0.5, 0.02, 1.0)
    after = augment(clouds, torch.full((1, 3), torch.nan), everything, torch.Generator().manual_seed(0))
    assert after.points.isfinite().all()
