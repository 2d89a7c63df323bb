"""The orbit of a pair: one pose of what has no symmetry; every turn of what repeats itself, and no other."""

import numpy as np
import pytest

from orbitscan.processing.registration.ambiguity.orbit import find_orbit
from orbitscan.processing.results.estimates import Symmetry
from orbitscan.recorder import poses
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS
from tests.geometry import scan
from tests.processing.scene import Scene


@pytest.fixture(scope="module")
def blob():
    scene = Scene(scan(n_views=2, step_deg=30))
    return scene.pair(scene.views[1], scene.views[0]), scene.T(0, 1)


@pytest.fixture(scope="module")
def prism(tmp_path_factory):
    """Two views of a hexagonal prism 45 degrees apart, the true pose, and its axis in the target's frame."""
    session = simulate(SOLIDS["prism06"].write(tmp_path_factory.mktemp("solid")), views=8)
    scene = Scene(session)
    T = poses.invert(session.truth()[0])
    pair = scene.pair(scene.views[1], scene.views[0])
    return pair, pair.align(scene.T(0, 1)).T_target_source, Symmetry(T[:3, 2], T[:3, 3], 6)


def test_a_wrong_pose_of_what_has_no_symmetry_is_refuted_by_far(blob):
    pair, T = blob
    wrong = poses.turn_about(np.array([0.0, 1, 0]), pair.center(T), np.radians(40)) @ T
    orbit = find_orbit(pair, T, [wrong], ())
    assert orbit.is_single
    assert orbit.margin > 2 * pair.settings.covisibility.worse
    assert find_orbit(pair, T, [], ()).margin is None


def test_a_suspected_symmetry_of_what_has_none_is_refuted(blob):
    pair, T = blob
    assert find_orbit(pair, T, [], (), [Symmetry(np.array([0.0, 1, 0]), pair.center(T), 4)]).is_single


def test_one_turned_pose_tells_the_whole_symmetry(prism):
    pair, T, symmetry = prism
    rival = pair.align(symmetry.turns()[0] @ T).T_target_source
    orbit = find_orbit(pair, T, [rival], ())
    (found,) = orbit.symmetries
    assert found.order == 6
    assert abs(found.axis @ symmetry.axis) > np.cos(np.radians(1))
    assert orbit.alternatives == ()


def test_it_is_told_from_whichever_of_its_poses(prism):
    """Also from one that overlaps more than the true one."""
    pair, T, symmetry = prism
    for turn in symmetry.turns()[:1] + symmetry.turns()[-1:]:
        start = pair.align(turn @ T).T_target_source
        assert [found.order for found in find_orbit(pair, start, [T], ()).symmetries] == [6]


def test_a_suspected_symmetry_that_there_is_stands(prism):
    pair, T, symmetry = prism
    assert find_orbit(pair, T, [], (), [symmetry]).symmetries == (symmetry,)
    twelve = Symmetry(symmetry.axis, symmetry.point, 12)
    assert find_orbit(pair, T, [], (), [twelve]).symmetries != (twelve,)
