"""How well a pose is known: the stated covariance against what poses of many noisy views scatter by."""

import numpy as np
import pytest

from orbitscan.processing.results.uncertainty import Uncertainty, bound
from orbitscan.recorder import poses
from tests.geometry import blob, scan
from tests.processing.scene import Scene, degrees


def known(scene):
    pair = scene.pair(scene.views[1], scene.views[0])
    refined = pair.align(scene.T(0, 1))
    return refined, pair.measure_uncertainty(refined)


@pytest.mark.parametrize("noise", [0.0005, 0.002])
def test_errors_lie_within_the_bound_and_not_far_within(noise):
    errors, bounds = [], []
    for seed in range(12):
        scene = Scene(scan(n_views=2, step_deg=20, surface=blob, noise=noise, seed=seed, points=6_000))
        refined, found = known(scene)
        errors.append(degrees(refined.T_target_source, scene.T(0, 1)))
        bounds.append(found.rotation_bound_deg)
    within = np.mean(np.array(errors) <= bounds)
    assert within >= 0.9
    assert np.median(np.array(bounds) / errors) < 6


def test_views_that_do_not_meet_have_no_bound():
    scene = Scene(scan(n_views=2, points=4_000))
    pair = scene.pair(scene.views[1], scene.views[0])
    assert pair.measure_uncertainty(pair.align(poses.make(np.eye(3), [9.0, 0, 0]))) is None


def test_the_bound_holds_what_it_says():
    rng = np.random.default_rng(0)
    for spread in ((1.0, 1.0, 1.0), (1.0, 0.1, 0.1), (1.0, 0.01, 0.0)):
        C = np.diag(np.square(spread))
        lengths = np.linalg.norm(rng.normal(size=(20_000, 3)) * spread, axis=1)
        assert np.mean(lengths <= bound(C)) == pytest.approx(0.95, abs=0.012)
    assert bound(np.zeros((3, 3))) == 0


def test_a_pose_is_good_where_its_bounds_are_no_more_than_what_is_wrong():
    turn, shift = np.radians(1.0) ** 2, 0.001**2
    assert Uncertainty(np.diag([turn] * 3 + [shift] * 3), np.zeros(3)).is_good(0.3)
    assert not Uncertainty(np.diag([9 * turn] * 3 + [shift] * 3), np.zeros(3)).is_good(0.3)
    assert not Uncertainty(np.diag([turn] * 3 + [100 * shift] * 3), np.zeros(3)).is_good(0.3)
    assert Uncertainty(np.eye(6) * 100, np.zeros(3)).rotation_bound_deg == 180
