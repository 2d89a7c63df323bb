"""A pair by each method: right where it can be, and its status says so where it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from processing.pipeline import _correspond, _describe
from processing.reconstruction import judgement
from processing.reconstruction.pair import PairSettings, register_competing, register_consensus, register_icp
from processing.settings import Settings
from processing.surface import choose_scale, prepare
from processing.timing import Stopwatch
from recorder import poses
from tests.geometry import random_pose, scan

SETTINGS = Settings()


@pytest.fixture(scope="module")
def prepared():
    session = scan(n_views=3, step_deg=30)
    views = session.views()
    scale = choose_scale(views, SETTINGS.surface)

    def of(view):
        surface = prepare(view, scale, (0, 0, 0), SETTINGS.surface)
        return _describe(surface, scale, SETTINGS, Stopwatch(), ["pairwise"])

    return session, scale, [of(view) for view in views], of


def error_deg(session, pair):
    truth = session.truth()
    T = poses.invert(truth[pair.target]) @ truth[pair.source]
    return np.degrees(poses.rotation_angle(T[:3, :3].T @ pair.T_target_source[:3, :3]))


def found_for(source, target, scale):
    correspondences, consensus = _correspond(source, target, scale, SETTINGS, 0, Stopwatch(), [])
    return len(correspondences.inlier), consensus


def test_competing_starts_end_at_the_truth(prepared):
    session, scale, (target, source, _), _ = prepared
    matches, consensus = found_for(source, target, scale)
    pair = register_competing(source, target, matches, consensus, scale, SETTINGS.pair)
    assert pair.status == "ok"
    assert error_deg(session, pair) < 0.2
    assert {candidate.start for candidate in pair.candidates} == {"identity", "consensus"}
    assert 0 < pair.confidence <= 1
    assert pair.evidence.overlap > 0.5
    assert pair.evidence.valid_frames <= pair.evidence.keypoints


def test_competition_beats_the_thesis(prepared):
    session, scale, (target, source, _), _ = prepared
    matches, consensus = found_for(source, target, scale)
    ours = register_competing(source, target, matches, consensus, scale, SETTINGS.pair)
    thesis = register_consensus(source, target, matches, consensus, scale, SETTINGS.pair)
    baseline = register_icp(source, target, scale, SETTINGS.pair)
    assert error_deg(session, ours) < min(error_deg(session, thesis), error_deg(session, baseline))


def test_an_unknown_start_is_found_by_the_features(prepared):
    session, scale, (target, _, _), of = prepared
    view = session.load(1)
    T = random_pose(np.random.default_rng(4), shift=0)
    turned = of(replace(view, points=poses.transform(T, view.points).astype(np.float32)))
    matches, consensus = found_for(turned, target, scale)
    pair = register_competing(turned, target, matches, consensus, scale, SETTINGS.pair)
    pair = replace(pair, T_target_source=pair.T_target_source @ T)
    assert pair.candidates[0].start == "consensus"
    assert error_deg(session, pair) < 0.5


def test_without_a_consensus_the_thesis_has_no_estimate_and_we_have_the_identity(prepared):
    _, scale, (target, source, _), _ = prepared
    thesis = register_consensus(source, target, 12, None, scale, SETTINGS.pair)
    assert (thesis.T_target_source, thesis.status, thesis.confidence) == (None, "no_consensus", 0.0)
    assert register_consensus(source, target, 1, None, scale, SETTINGS.pair).status == "too_few_matches"
    ours = register_competing(source, target, 12, None, scale, SETTINGS.pair)
    assert [candidate.start for candidate in ours.candidates] == ["identity"]


def test_views_that_do_not_meet_are_not_called_right(prepared):
    session, scale, (target, _, _), of = prepared
    view = session.load(1)
    rng = np.random.default_rng(0)
    elsewhere = of(replace(view, points=(rng.random((5000, 3)) * 0.2 + [0, 0, 3]).astype(np.float32)))
    pair = register_competing(elsewhere, target, 0, None, scale, PairSettings())
    assert pair.status in ("low_overlap", "diverged")
    assert pair.confidence < 0.2


def test_the_true_pose_is_judged_better_than_any_near_it(prepared):
    session, scale, (target, source, _), _ = prepared
    truth = session.truth()
    T = poses.invert(truth[0]) @ truth[1]
    center = source.surface.working.mean(axis=0)

    def score(T):
        return judgement.judge(T, source.surface, target.surface, target.tree, scale, SETTINGS.pair.judgement).score

    right = score(T)
    about = poses.make(np.eye(3), center)
    for seed in range(10):
        off = about @ random_pose(np.random.default_rng(seed), angle=0.3, shift=0.01) @ poses.invert(about)
        assert score(T @ off) < right


def test_distinct_poses_are_told_apart(prepared):
    _, scale, (_, source, _), _ = prepared
    center = source.surface.working.mean(axis=0)
    how = SETTINGS.pair.judgement
    near = poses.make(np.eye(3), [0.001, 0, 0])
    far = poses.make(np.eye(3), [0.5, 0, 0])
    assert not judgement.distinct(np.eye(4), near, center, scale, how)
    assert judgement.distinct(np.eye(4), far, center, scale, how)
