"""ICP between surfaces comes back to a pose it is started near to, and says how well it knows it."""

import numba
import numpy as np
import pytest

from orbitscan.processing.registration import surface_icp
from orbitscan.processing.registration.icp import icp
from orbitscan.processing.registration.surface_icp import RefinementSettings
from orbitscan.recorder import poses
from tests.geometry import random_pose, scan
from tests.processing.scene import Scene, degrees

HOW = RefinementSettings()
NOISE = 0.0005


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=2, noise=NOISE))


def aligned(scene, start, source=1, target=0):
    view, scale = scene.views[source], scene.scale
    fine = scene.views[target].fine_target
    return surface_icp.align(view.surface.surfels, view.coarse_surfels, fine, start, scale.working, scale.diameter, HOW)


def nudged(scene, seed, source=1, target=0):
    """The true pose after a turn of some degrees and a shift of some millimetres about the object."""
    T = scene.T(target, source)
    center = poses.make(np.eye(3), poses.transform(T, scene.views[source].surface.surfels.points).mean(axis=0))
    off = random_pose(np.random.default_rng(seed), angle=np.radians(5), shift=0.0015)
    return center @ off @ poses.invert(center) @ T


def off_center(scene, found, source=1, target=0):
    """(6,) the turn and the shift of the centre between what was found and the truth, as information counts them."""
    D = found.T_target_source @ poses.invert(scene.T(target, source))
    turn = D[:3, :3]
    vector = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    return np.concatenate([vector, poses.transform(D, found.center[None])[0] - found.center])


@pytest.mark.parametrize("seed", range(5))
def test_surfaces_are_aligned_to_well_below_the_noise(scene, seed):
    start = nudged(scene, seed)
    found = aligned(scene, start)
    assert found.converged
    assert degrees(found.T_target_source, scene.T(0, 1)) < 0.2
    assert np.linalg.norm(off_center(scene, found)[3:]) < NOISE / 4
    points = scene.views[1].surface.working
    plain = icp(points, scene.views[0].tree, start, HOW.icp_gate * scene.scale.working, 100, 1e-7)
    assert degrees(plain.T_target_source, scene.T(0, 1)) > 3 * degrees(found.T_target_source, scene.T(0, 1))


def test_it_ends_in_one_place_wherever_it_begins(scene):
    ends = np.array([aligned(scene, nudged(scene, seed)).T_target_source for seed in range(5)])
    assert np.ptp(ends, axis=0).max() < 1e-4


def test_without_noise_it_is_nearly_exact():
    quiet = Scene(scan(n_views=2, noise=0.0))
    found = aligned(quiet, nudged(quiet, 0))
    assert degrees(found.T_target_source, quiet.T(0, 1)) < 0.01
    assert np.linalg.norm(off_center(quiet, found)[3:]) < 1e-5


def test_there_and_back_are_inverse(scene):
    there = aligned(scene, scene.T(0, 1))
    back = aligned(scene, scene.T(1, 0), source=0, target=1)
    assert degrees(there.T_target_source, poses.invert(back.T_target_source)) < 0.1


def test_the_information_predicts_the_spread_of_errors():
    """Six errors whitened by the information have the variance one; over some pairs of views, within a factor."""
    squares = []
    for seed in range(6):
        scene = Scene(scan(n_views=2, noise=NOISE, seed=seed, points=12_000))
        found = aligned(scene, scene.T(0, 1))
        error = off_center(scene, found)
        squares.append(error @ found.information @ error / 6)
    assert 0.3 < np.mean(squares) < 3.0


def test_the_information_is_symmetric_and_positive(scene):
    A = aligned(scene, scene.T(0, 1)).information
    assert np.allclose(A, A.T)
    assert np.linalg.eigvalsh(A).min() > 0


def test_one_thread_and_two_find_the_same_bits(scene):
    starts = np.array([nudged(scene, seed) for seed in range(8)])
    w, view, target = scene.scale.working, scene.views[1], scene.views[0]
    found = []
    before = numba.get_num_threads()
    try:
        for threads in (1, min(2, before)):
            numba.set_num_threads(threads)
            coarse = surface_icp.align_coarsely(
                view.coarse_surfels, target.coarse_target, starts, HOW.coarse_gate * w, w, 20, 1e-5
            )
            fine = aligned(scene, starts[0])
            found.append((coarse.tobytes(), fine.T_target_source.tobytes(), fine.information.tobytes()))
    finally:
        numba.set_num_threads(before)
    assert found[0] == found[1]


def test_few_surfels_take_far_starts_near(scene):
    """Some fifteen degrees off, as starts are."""
    w, rng = scene.scale.working, np.random.default_rng(0)
    T, view = scene.T(0, 1), scene.views[1]
    center = poses.make(np.eye(3), poses.transform(T, view.coarse_surfels.points).mean(axis=0))
    starts = [center @ random_pose(rng, 0.35, 0.004) @ poses.invert(center) @ T for _ in range(20)]
    few, gate, deviation = (view.coarse_surfels, scene.views[0].coarse_target), HOW.coarse_gate, HOW.coarse_deviation
    ends = surface_icp.align_coarsely(*few, np.array(starts), gate * w, deviation * w, 40, 1e-6)
    away = np.array([degrees(start, T) for start in starts])
    assert np.median(away) > 8
    assert np.median([degrees(end, T) for end in ends]) < 0.5


def test_a_start_that_has_no_correspondences_stays(scene):
    far = poses.make(np.eye(3), [9.0, 0, 0])
    ends = surface_icp.align_coarsely(
        scene.views[1].coarse_surfels, scene.views[0].coarse_target, far[None], 0.01, 0.002, 20, 1e-6
    )
    assert (ends[0] == far).all()
    found = aligned(scene, far)
    assert not found.converged
    assert (found.T_target_source == far).all()


def test_without_iterations_the_pose_stays(scene):
    view, scale = scene.views[1], scene.scale
    still = RefinementSettings(middle_iterations=0, fine_iterations=0)
    how = scene.views[0].fine_target, scene.T(0, 1), scale.working, scale.diameter, still
    found = surface_icp.align(view.surface.surfels, view.coarse_surfels, *how)
    assert np.allclose(found.T_target_source, scene.T(0, 1))
    assert not found.converged
    assert found.information is None
