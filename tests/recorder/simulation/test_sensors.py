import numpy as np
import pytest

from orbitscan.recorder import cloud, poses
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.camera import simulate
from orbitscan.recorder.simulation.sensors import Kinect
from orbitscan.recorder.sources import open_capture

FACING = np.ones((120, 160))


def rng(seed=0):
    return np.random.default_rng(seed)


def measured(depth, sensor=None, cosine=FACING, seed=0):
    return (sensor or Kinect(holes=0)).measure(np.full(FACING.shape, depth), cosine, rng(seed))


@pytest.mark.parametrize("depth", [0.7, 1.0, 1.5])
def test_depths_are_whole_millimetres_of_whole_eighths_of_disparity(depth):
    z = np.unique(measured(depth))
    z = z[np.isfinite(z)]
    np.testing.assert_allclose(z, np.round(z, 3), atol=1e-12)
    assert len(z) > 2
    assert np.diff(z).mean() == pytest.approx(depth**2 / (8 * 575 * 0.075), rel=0.25)


def test_the_error_grows_with_the_square_of_depth():
    spread = {}
    for depth in (1.0, 2.0):
        slope = np.broadcast_to(np.linspace(0.99, 1.01, 160) * depth, FACING.shape)
        found = [Kinect(holes=0).measure(slope, FACING, rng(seed)) - slope for seed in range(10)]
        spread[depth] = np.std(found)
    quantisation = 1 / (8 * 575 * 0.075) / np.sqrt(12)
    assert spread[1.0] == pytest.approx(np.hypot(0.001, quantisation), rel=0.05)
    assert spread[2.0] == pytest.approx(4 * spread[1.0], rel=0.05)


def test_nothing_is_measured_beyond_eight_metres():
    assert np.isfinite(measured(7.9)).all()
    assert np.isnan(measured(8.1)).all()


def test_a_kinect_too_far_away_is_refused():
    with pytest.raises(InvalidOption, match=r"distance=9.0: a Kinect sees nothing beyond 8 m"):
        simulate("bowl", sensor="kinect", distance=9)


@pytest.mark.parametrize("shape", [(300, 300), (7, 400)])
def test_pixels_shift_by_a_pixel_or_so_and_neighbours_alike(shape):
    right, down = np.moveaxis([Kinect().shift(shape, rng(seed)) for seed in range(40)], 1, 0)
    assert np.mean(right * down) == pytest.approx(0, abs=0.06)
    for shifts in (right, down):
        assert shifts.mean() == pytest.approx(0, abs=0.03)
        assert shifts.std() == pytest.approx(Kinect.RAGGED, abs=0.03)
        for lag in (1, 3, 6):
            along = (shifts[:, :, lag:] * shifts[:, :, :-lag]).mean()
            assert along == pytest.approx(np.exp(-(lag**2) / (2 * Kinect.OUTLINE**2)), abs=0.06)


def test_what_faces_the_camera_is_seen_but_for_the_holes_and_what_grazes_is_not():
    assert np.isfinite(measured(0.7)).all()
    assert not np.isfinite(measured(0.7, cosine=0.1 * FACING)).any()
    lost = [np.isnan(measured(0.7, Kinect(holes=0.02), seed=seed)).mean() for seed in range(20)]
    assert np.mean(lost) == pytest.approx(0.02, rel=0.4)


def test_a_few_points_at_edges_fly_behind_the_object():
    depth = np.full(FACING.shape, np.inf)
    depth[20:100, 30:130] = 0.7
    far = sum(np.nansum(Kinect(holes=0).measure(depth, FACING, rng(seed)) > 0.71) for seed in range(20))
    edge = 20 * 2 * (80 + 100)
    assert 0.001 * edge < far < 0.01 * edge


@pytest.mark.parametrize("height", [0.004, 0.02, 0.1, 0.5])
def test_the_table_never_takes_more_than_two_fifths(height):
    cuts = []
    for seed in range(200):
        sensor = Kinect.draw(rng(seed), height, 0.001)
        cuts.append(sensor.table_cut(rng(seed)))
        assert 0 <= cuts[-1] <= 0.4 * height
    assert np.median(cuts) == pytest.approx(min(0.0075, 0.4 * height), rel=0.25)
    assert max(cuts) <= max(0.02, 0.2 * height + 0.006)


def test_a_kinects_view_of_an_object():
    session = simulate("coffee_mug", instance=2, views=8, sensor="kinect")
    plain = simulate("coffee_mug", instance=2, views=8, distance=0.72, focal=570)
    assert session.info.sensor.startswith("virtual Kinect (0.72 m, 570 pixels, 1 mm, seed 0)")
    height = objects.build("coffee_mug", 2).bounds[1][2]
    for view, other in zip(session.views(), plain.views(), strict=True):
        assert view.points.dtype == np.float32
        assert view.colors.shape == view.points.shape
        assert 0.75 < len(view.points) / len(other.points) < 1.1
        placed = poses.transform(session.truth()[view.index], view.points)
        assert placed[:, 2].min() < 0.4 * height
        assert cloud.measure(view.points).resolution == pytest.approx(0.72 / 570, rel=0.1)


def test_virtual_views_are_as_dense_and_as_noisy_as_real_ones(data):
    real = open_capture(data / "washington" / "rgbd-dataset" / "cap")[0]
    ours = simulate("cap", views=6, sensor="kinect")
    facts = [[cloud.measure(cloud.finite(view.points)[0]) for view in s.views("6")] for s in (real, ours)]
    for of, tolerance in ((lambda f: f.resolution, 0.1), (lambda f: f.noise, 0.25), (lambda f: f.points, 0.3)):
        theirs, mine = (np.median([of(fact) for fact in found]) for found in facts)
        assert mine == pytest.approx(theirs, rel=tolerance)
