"""What geometry alone can tell of a pose, and what it must say it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.verification import (
    Verification,
    VerificationSettings,
    confidence,
    distance,
    status_of,
    verify,
)
from orbitscan.recorder import poses
from tests.geometry import random_pose, scan
from tests.processing.scene import Scene

HOW = VerificationSettings()
GOOD = Verification(overlap=0.8, rmse=0.0004, misfit=0.8, violations=0.0, unseen=0.0, score=0.85)


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=3, step_deg=30))


def shifted(scene, T, along, metres):
    """A pose after a shift along the target's line of sight (z) or across it (x)."""
    return poses.make(np.eye(3), metres * np.eye(3)["xyz".index(along)]) @ T


def test_the_truth_is_believed(scene):
    found = verify(scene.T(0, 1), scene.views[1], scene.views[0], HOW)
    assert status_of(found, HOW) == status_of(found, HOW, nearly_slides=True) == "ok"
    assert found.overlap > 0.6
    assert found.violations < 0.005
    assert found.unseen < 0.005
    assert 0.1 < found.misfit < 1
    assert found.rmse < 0.0006
    assert 0.7 < found.score <= 1


def test_less_overlap_is_less_score_but_still_the_truth(scene):
    near = verify(scene.T(0, 1), scene.views[1], scene.views[0], HOW)
    far = verify(scene.T(0, 2), scene.views[2], scene.views[0], HOW)
    assert far.overlap < near.overlap
    assert 0.6 < far.score < near.score
    assert status_of(far, HOW) == "ok"


def test_the_truth_scores_more_than_any_pose_near_it(scene):
    T = scene.T(0, 1)
    right = verify(T, scene.views[1], scene.views[0], HOW)
    about = poses.make(np.eye(3), poses.transform(T, scene.views[1].surface.working).mean(axis=0))
    for seed in range(20):
        off = about @ random_pose(np.random.default_rng(seed), angle=0.3, shift=0.01) @ poses.invert(about)
        assert verify(off @ T, scene.views[1], scene.views[0], HOW).score < right.score


def test_source_and_target_count_alike(scene):
    T = shifted(scene, scene.T(0, 1), "x", 0.004)
    there = verify(T, scene.views[1], scene.views[0], HOW)
    back = verify(poses.invert(T), scene.views[0], scene.views[1], HOW)
    for name in vars(there):
        assert getattr(there, name) == pytest.approx(getattr(back, name), rel=1e-6, abs=1e-9)


def test_a_few_surfels_tell_nearly_the_same(scene):
    whole = verify(scene.T(0, 1), scene.views[1], scene.views[0], HOW)
    few = verify(scene.T(0, 1), scene.views[1], scene.views[0], HOW, coarse=True)
    assert len(scene.views[1].coarse_surfels) < len(scene.views[1].surface.surfels)
    assert few.score == pytest.approx(whole.score, abs=0.05)
    assert few.overlap == pytest.approx(whole.overlap, abs=0.05)


@pytest.mark.parametrize("metres", [0.015, -0.015])
def test_a_surface_before_another_contradicts_and_not_only_behind_it(scene, metres):
    """One view nearer or farther than it is: either way it stands in front of the other for one of the sensors."""
    found = verify(shifted(scene, scene.T(0, 1), "z", metres), scene.views[1], scene.views[0], HOW)
    assert found.violations > 0.2
    assert found.score < 0 < found.overlap
    assert status_of(found, HOW) in ("inconsistent", "low_overlap")


def test_where_nothing_was_seen_nothing_can_be(scene):
    found = verify(shifted(scene, scene.T(0, 1), "x", 0.08), scene.views[1], scene.views[0], HOW)
    assert found.unseen > 0.1
    assert found.score < 0.3


def test_poses_that_do_not_meet_agree_in_nothing(scene):
    found = verify(shifted(scene, scene.T(0, 1), "x", 9.0), scene.views[1], scene.views[0], HOW)
    assert (found.overlap, found.score) == (0.0, 0.0)
    assert status_of(found, HOW) == "low_overlap"


def test_without_sensors_nothing_contradicts(scene):
    views = [scene.prepare(scene.session.load(i), sensor_origin=None) for i in (0, 1)]
    found = verify(shifted(scene, scene.T(0, 1), "x", 0.03), views[1], views[0], HOW)
    assert (found.violations, found.unseen) == (0.0, 0.0)
    assert verify(scene.T(0, 1), views[1], views[0], HOW).score > 0.7


@pytest.mark.parametrize("frame", range(3))
def test_frames_do_not_matter(scene, frame):
    M = random_pose(np.random.default_rng(frame))
    moved = replace(scene.session.load(1), points=poses.transform(M, scene.session.load(1).points).astype(np.float32))
    source = scene.prepare(moved, sensor_origin=tuple(M[:3, 3]))
    before = verify(scene.T(0, 1), scene.views[1], scene.views[0], HOW)
    after = verify(scene.T(0, 1) @ poses.invert(M), source, scene.views[0], HOW)
    assert after.score == pytest.approx(before.score, abs=0.02)
    assert after.overlap == pytest.approx(before.overlap, abs=0.03)
    assert after.violations < 0.005


@pytest.mark.parametrize(
    ("change", "status"),
    [
        ({}, "ok"),
        ({"overlap": HOW.min_overlap - 0.01}, "low_overlap"),
        ({"violations": HOW.max_violations + 0.01}, "inconsistent"),
        ({"misfit": HOW.max_misfit + 0.1}, "diverged"),
        ({"score": HOW.min_score - 0.01}, "diverged"),
        ({"overlap": 0.0, "violations": 1.0, "misfit": np.inf}, "low_overlap"),
    ],
)
def test_the_status_names_what_is_wrong(change, status):
    assert status_of(replace(GOOD, **change), HOW) == status


def test_where_views_nearly_slide_a_little_contradiction_is_enough():
    doubtful = replace(GOOD, violations=0.6 * HOW.strict_violations, unseen=0.6 * HOW.strict_violations)
    assert status_of(doubtful, HOW) == "ok"
    assert status_of(doubtful, HOW, nearly_slides=True) == "inconsistent"


def test_distance_is_one_where_poses_just_count_as_distinct(scene):
    source = scene.views[1]
    center = source.coarse_surfels.points.mean(axis=0)
    turned = poses.turn_about(np.array([0.0, 1, 0]), center, np.radians(HOW.distinct_deg))
    moved = poses.make(np.eye(3), [HOW.distinct_shift * scene.scale.diameter, 0, 0])
    assert distance(np.eye(4), np.eye(4), source, HOW) < 1e-9
    assert distance(turned, np.eye(4), source, HOW) == pytest.approx(1)
    assert distance(moved, np.eye(4), source, HOW) == pytest.approx(1)
    assert distance(turned, np.eye(4), source, HOW) == pytest.approx(distance(np.eye(4), turned, source, HOW))


def test_confidence_falls_as_a_rival_comes_near():
    rivals = [0.0, 0.3, 0.6, 0.8, GOOD.score]
    found = [confidence(GOOD, rival) for rival in rivals]
    assert found[0] == GOOD.score
    assert (np.diff(found) < 0).all()
    assert found[-1] == 0
    assert confidence(GOOD, -3.0) == GOOD.score
    assert confidence(replace(GOOD, score=-0.5), 0.2) == 0
