"""A pair by each method: right where it can be, and its status says so where it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.competition import look, register_competing, register_from, register_near
from orbitscan.processing.registration.icp import register_icp
from orbitscan.processing.registration.matching import choose_correspondences
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.ransac import Matches
from orbitscan.recorder import poses
from tests.geometry import blob, bottle, plane, random_pose, scan
from tests.processing.scene import SETTINGS, Scene, degrees, edge

NONE = Matches(np.empty((0, 2), np.int64), None)
HOW = SETTINGS.pair


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=3, step_deg=30))


@pytest.fixture(scope="module")
def found(scene):
    """The matches of the first two views."""
    return scene.correspond(scene.views[1], scene.views[0])


def error_deg(scene, pair):
    return degrees(pair.T_target_source, scene.T(pair.target, pair.source))


def started(pair):
    """Where what competed began; poses turned about a weak axis come from one of these too."""
    return {candidate.start.split(",")[0] for candidate in pair.candidates}


def test_competing_starts_end_at_the_truth(scene, found):
    target, source, _ = scene.views
    pair = register_competing(scene.pair(source, target), found)
    assert pair.status == "ok"
    assert error_deg(scene, pair) < 0.3
    assert 0.5 < pair.confidence <= 1
    assert pair.freedoms == ()
    assert pair.alternatives == ()
    scores = [candidate.score for candidate in pair.candidates]
    assert scores == sorted(scores, reverse=True)


def test_evidence_says_what_was_seen(scene, found):
    target, source, _ = scene.views
    evidence = register_competing(scene.pair(source, target), found).evidence
    assert evidence.points == len(source.surface.working)
    assert evidence.keypoints == len(source.keypoints)
    assert 0 < evidence.valid_frames <= evidence.keypoints
    assert evidence.matches == len(found.indices)
    assert evidence.inlier_ratio == evidence.inliers / evidence.matches
    assert evidence.converged
    assert evidence.overlap > 0.5
    assert 0.1 < evidence.misfit < 1
    assert evidence.violations < 0.005
    assert 0.005 < evidence.observability < 0.2


def test_the_correspondences_shown_are_those_behind_the_last_methods_pair(scene, found):
    target, source, other = scene.views
    pairs = {"icp": edge(1, 0, np.eye(4)), "ransac_icp": edge(1, 0, np.eye(4)), "pairwise": edge(1, 2, np.eye(4))}
    beside = scene.correspond(source, other)
    for matched, expected in (({target: found, other: beside}, 2), ({other: beside, target: found}, 2)):
        assert choose_correspondences(source, pairs, matched).target == expected
    shown = choose_correspondences(source, {"ransac_icp": pairs["ransac_icp"]}, {target: found})
    assert (shown.source, shown.target) == (1, 0)
    assert (shown.source_points == source.keypoints[found.indices[:, 0]]).all()
    assert (shown.target_points == target.keypoints[found.indices[:, 1]]).all()
    assert shown.inlier.sum() == found.consensus.inlier.sum()
    assert choose_correspondences(source, {"icp": pairs["icp"]}, {}) is None


def test_competition_beats_the_thesis(scene, found):
    target, source, _ = scene.views
    ours = register_competing(scene.pair(source, target), found)
    thesis = register_icp(scene.pair(source, target), found)
    baseline = register_icp(scene.pair(source, target))
    assert error_deg(scene, ours) < min(error_deg(scene, thesis), error_deg(scene, baseline))


def test_the_thesis_starts_at_the_consensus_and_the_baseline_at_the_identity(scene, found):
    target, source, _ = scene.views
    right = replace(found.consensus, T_target_source=scene.T(0, 1))
    thesis = register_icp(scene.pair(source, target), Matches(found.indices, right))
    assert error_deg(scene, thesis) < 3
    assert thesis.evidence.inliers == right.inlier.sum()
    assert register_icp(scene.pair(source, target)).evidence.matches is None


@pytest.mark.parametrize("seed", range(3))
def test_an_unknown_start_is_found_by_the_features(scene, seed):
    view = scene.session.load(1)
    T = random_pose(np.random.default_rng(seed), shift=0)
    turned = scene.prepare(replace(view, points=poses.transform(T, view.points).astype(np.float32)))
    matches = scene.correspond(turned, scene.views[0])
    pair = register_competing(scene.pair(turned, scene.views[0]), matches)
    assert pair.status == "ok"
    assert pair.candidates[0].start != "identity"
    assert error_deg(scene, replace(pair, T_target_source=pair.T_target_source @ T)) < 0.3


def test_the_previous_step_is_a_start(scene):
    """Without features, and sixty degrees from the identity, the step before is what helps."""
    target, _, source = scene.views
    alone = replace(HOW, starts=("identity", "previous"))
    blind = register_competing(scene.pair(source, target, alone), NONE)
    told = register_competing(scene.pair(source, target, alone), NONE, {"previous": scene.T(0, 2)})
    assert started(blind) == {"identity"}
    assert blind.status != "ok"
    assert started(told) <= {"identity", "previous"}
    assert told.candidates[0].start.split(",")[0] == "previous"
    assert told.status == "ok"
    assert error_deg(scene, told) < 0.5


def test_only_the_starts_that_are_asked_for_compete(scene, found):
    target, source, _ = scene.views
    only = replace(HOW, starts=("identity",))
    pair = register_competing(scene.pair(source, target, only), found, {"previous": scene.T(0, 1)})
    assert started(pair) == {"identity"}
    only = replace(HOW, starts=("consensus",))
    pair = register_competing(scene.pair(source, target, only), found, {"previous": scene.T(0, 1)})
    assert {start.split()[0] for start in started(pair)} <= {"consensus", "ransac"}


def test_without_any_start_there_is_no_estimate(scene, found):
    """Nobody knows a step before the second view; nor do views without keypoints propose anything."""
    target, source, _ = scene.views
    pair = register_competing(scene.pair(source, target, replace(HOW, starts=("previous",))), found)
    assert (pair.T_target_source, pair.status, pair.confidence) == (None, "no_consensus", 0.0)
    bare = replace(source, keypoints=source.keypoints[:0], descriptors=source.descriptors[:0])
    pair = register_competing(scene.pair(bare, target, replace(HOW, starts=("consensus",))), NONE)
    assert (pair.T_target_source, pair.status) == (None, "too_few_keypoints")


def test_views_that_hardly_share_surfels_are_not_called_right(scene, found, monkeypatch):
    """Fewer than six surfels that correspond determine no motion, whatever the overlap of the smaller view says."""
    monkeypatch.setattr(PairRegistration, "find_motions", lambda *_, **__: [])
    target, source, _ = scene.views
    ours = register_from(scene.pair(source, target), {"truth": scene.T(0, 1)})
    right = Matches(found.indices, replace(found.consensus, T_target_source=scene.T(0, 1)))
    thesis = register_icp(scene.pair(source, target), right)
    assert (ours.status, thesis.status) == ("low_overlap", "low_overlap")
    assert ours.evidence.observability is None


def test_a_pose_that_was_not_refined_did_not_converge(scene):
    target, source, _ = scene.views
    away = register_from(scene.pair(source, target), {"away": poses.make(np.eye(3), [9.0, 0, 0])})
    assert away.status == "low_overlap"
    assert not away.evidence.converged


def test_without_a_consensus_the_thesis_has_no_estimate_and_we_look_again(scene, found):
    target, source, _ = scene.views
    thesis = register_icp(scene.pair(source, target), Matches(found.indices[:12], None))
    assert (thesis.T_target_source, thesis.status, thesis.confidence) == (None, "no_consensus", 0.0)
    assert register_icp(scene.pair(source, target), Matches(found.indices[:1], None)).status == "too_few_matches"
    few = replace(source, keypoints=source.keypoints[:2], descriptors=source.descriptors[:2])
    assert register_icp(scene.pair(few, target), NONE).status == "too_few_keypoints"
    # It looks for matches itself where the identity leads nowhere.
    ours = register_competing(scene.pair(source, target), NONE)
    assert ours.status == "ok"
    assert error_deg(scene, ours) < 0.5


def test_views_that_do_not_meet_are_not_called_right(scene):
    view, rng = scene.session.load(1), np.random.default_rng(0)
    points = (blob(rng, 8000)[0] + [0, 0, 3]).astype(np.float32)
    elsewhere = scene.prepare(replace(view, points=points))
    pair = register_from(scene.pair(elsewhere, scene.views[0]), {"identity": np.eye(4)})
    assert pair.status in ("low_overlap", "diverged")
    assert pair.confidence < 0.2
    assert pair.evidence.rmse_m is None


def test_a_wrong_start_is_not_called_right(scene):
    """Left where it ended: another place on the object fits a little, and geometry refutes it."""
    target, source, _ = scene.views
    middle = poses.transform(scene.T(0, 1), source.coarse_surfels.points).mean(axis=0)
    called_ok = []
    for seed in range(12):
        off = random_pose(np.random.default_rng(seed), shift=0)
        start = poses.make(np.eye(3), middle) @ off @ poses.make(np.eye(3), -middle) @ scene.T(0, 1)
        pair = register_from(scene.pair(source, target), {"wrong": start})
        if pair.status == "ok":
            called_ok.append(error_deg(scene, pair))
    assert max(called_ok, default=0) < 5


def test_there_and_back_are_one_pair(scene):
    target, source, _ = scene.views
    there = scene.register(source, target)
    back = scene.register(target, source)
    assert there.status == back.status == "ok"
    assert degrees(there.T_target_source, poses.invert(back.T_target_source)) < 0.15


def test_a_bottle_is_ambiguous_about_its_axis_and_a_plane_every_way():
    round_about = Scene(scan(n_views=2, surface=bottle, points=8_000))
    pair = round_about.register(round_about.views[1], round_about.views[0])
    assert pair.status == "ambiguous"
    assert [freedom.kind for freedom in pair.freedoms] == ["turn"]
    flat = Scene(scan(n_views=2, surface=plane, points=8_000))
    pair = flat.register(flat.views[1], flat.views[0])
    assert pair.status != "ok"


def test_the_estimate_says_how_well_it_is_known(scene, found):
    pair = register_competing(scene.pair(scene.views[1], scene.views[0]), found)
    assert np.linalg.eigvalsh(pair.information).min() > 0
    middle = poses.transform(pair.T_target_source, scene.views[1].surface.surfels.points).mean(axis=0)
    assert np.linalg.norm(pair.center - middle) < 0.001


@pytest.mark.parametrize("step_deg", [20.0, -20.0])
def test_a_known_step_settles_a_bottles_turn(step_deg):
    """Whichever way the camera goes round; views may be several steps apart."""
    scene = Scene(scan(n_views=3, step_deg=step_deg, surface=bottle, points=8_000))
    told = replace(HOW, step_deg=step_deg)
    for source, target in ((1, 0), (2, 0), (0, 1)):
        views = scene.views[source], scene.views[target]
        pair = register_competing(scene.pair(*views, told), scene.correspond(*views))
        assert (pair.status, pair.start) == ("ok", "step")
        assert pair.freedoms == ()
        assert error_deg(scene, pair) < 0.5
        assert np.linalg.eigvalsh(pair.information).min() > 0


def test_a_known_step_changes_nothing_where_the_views_agree_with_it(scene, found):
    target, source, _ = scene.views
    alone, told = (
        register_competing(scene.pair(source, target, replace(HOW, step_deg=step_deg)), found)
        for step_deg in (None, 30.0)
    )
    assert (alone.T_target_source == told.T_target_source).all()
    assert alone.status == told.status == "ok"
    assert told.start != "step"


@pytest.mark.parametrize("step_deg", [77.0, -30.0])
def test_views_that_decide_against_a_known_step_are_inconsistent(scene, found, step_deg):
    target, source, _ = scene.views
    pair = register_competing(scene.pair(source, target, replace(HOW, step_deg=step_deg)), found)
    assert pair.status == "inconsistent"


def test_a_first_look_tells_views_that_overlap_from_others(scene):
    target, source, _ = scene.views
    other = Scene(scan(n_views=1, surface=bottle)).views[0]
    assert look(scene.pair(source, target)) > 0.7
    assert look(scene.pair(source, target)) > look(scene.pair(other, target)) + 0.2


def test_a_pair_is_aligned_from_where_others_predict_it(scene):
    target, source, _ = scene.views
    start = random_pose(np.random.default_rng(0), angle=0.05, shift=0.005) @ scene.T(0, 1)
    pair = register_near(scene.pair(source, target), "graph", start)
    assert pair.status == "ok"
    assert pair.start == "graph"
    assert error_deg(scene, pair) < 0.3
    far = register_near(scene.pair(source, target), "graph", random_pose(np.random.default_rng(1)))
    assert not far.status.is_believed


def test_what_may_slide_bears_no_prediction_out():
    """Aligned from anywhere about its axis a bottle stays there: that is no evidence."""
    bottles = Scene(scan(n_views=2, surface=bottle))
    target, source = bottles.views
    pair = register_near(bottles.pair(source, target), "graph", bottles.T(0, 1))
    assert pair.status == "ambiguous"
    assert pair.information is None
