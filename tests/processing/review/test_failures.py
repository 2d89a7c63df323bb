"""Sessions in which much or all fails: written, worded, and drawn without a complaint of the viewer."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.results.estimates import Evidence, MethodResult, ViewEstimate
from orbitscan.processing.results.records import SessionResult, ViewResult
from orbitscan.processing.results.status import METHODS, Status
from tests import viewer
from tests.processing.review.made_results import EMPTY, Results, make_info, make_results, review_results, true_poses
from tests.processing.review.recordings import read_rows, run_rerun

DAMAGE = "the chunk's checksum is wrong"


def select(session: SessionResult, views: list[ViewResult], **fields: object) -> SessionResult:
    """The session of these views by what they say themselves."""
    placed = {m: tuple(v.poses[min(m, "pairwise", key=METHODS.index)] for v in views) for m in METHODS}
    pairs = {m: tuple(v.pairs[m] for v in views if m in v.pairs) for m in METHODS}
    return replace(
        session,
        info=make_info(len(views)),
        views_used=tuple(v.view for v in views),
        view_names=tuple(v.name for v in views),
        stamps_ns=tuple(v.stamp_ns for v in views),
        origin=views[0].origin,
        reconstruction={m: MethodResult.of(placed[m], pairs[m], 0) for m in METHODS},
        **{"model": None, "turntable": None, "coverage": None} | fields,
    )


def one_view() -> Results:
    views, session = make_results()
    return views[:1], select(session, views[:1], model=session.model)


def no_consensus() -> Results:
    """All but the first fail; one is damaged, too."""
    views, session = make_results()
    lost: list[ViewResult] = [views[0]]
    for view in views[1:]:
        status = Status.UNREADABLE if view.view == EMPTY else Status.NO_CONSENSUS
        evidence = Evidence(points=1900, keypoints=40, valid_frames=38, matches=12)
        pairs = {
            m: replace(p, T_target_source=None, status=status, confidence=0.0, evidence=evidence)
            for m, p in view.pairs.items()
        }
        poses = {m: ViewEstimate(view.view, status, None) for m in view.poses}
        damage = DAMAGE if view.view == EMPTY else None
        lost.append(replace(view, pairs=pairs, poses=poses, damage=damage))
    return lost, select(session, lost, unreadable={EMPTY: DAMAGE})


def nothing_readable() -> Results:
    views, session = make_results()
    empty, none = np.empty((0, 3), np.float32), np.empty((0, 3))
    lost = [
        replace(
            view,
            points=empty,
            keypoints=none,
            correspondences=None,
            pairs={},
            poses={m: ViewEstimate(view.view, Status.UNREADABLE, None) for m in view.poses},
            origin=None,
            damage=DAMAGE,
        )
        for view in views
    ]
    return lost, select(session, lost, unreadable={view.view: DAMAGE for view in lost})


@pytest.mark.usefixtures("renderer")
@pytest.mark.parametrize(("make", "with_truth"), [(one_view, True), (no_consensus, True), (nothing_readable, False)])
def test_the_viewer_does_not_complain(make, with_truth, tmp_path):
    path = tmp_path / "review.rrd"
    views, _ = review_results(path, make(), truth=true_poses(5) if with_truth else {})
    assert run_rerun("rrd", "verify", path).returncode == 0
    with viewer.open_viewer(path) as client:
        assert client.get_state().views
        assert viewer.find_reports(client) == []
    assert len(read_rows(path, "/story", "TextDocument:text")["/story"]) == len(views)


def test_the_worst_come_first_and_say_why(tmp_path):
    review_results(tmp_path / "review.rrd", no_consensus())
    words = read_rows(tmp_path / "review.rrd", "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "refined places 1 of 5 views with confidence; no_consensus: 1, 2, 3; unreadable: 4" in words
    assert f"- **view 4 (scan04)**: {DAMAGE}" in words
    assert "view 2 (scan02)**: no_consensus (no motion explains enough of the matches), not placed" in words
    pairwise = tmp_path / "pairwise.rrd"
    review_results(pairwise, no_consensus(), METHODS[:3])
    words = read_rows(pairwise, "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "1,900 points → 40 keypoints → 38 with a frame → 12 matches" in words
    assert "identity (score 0.1) lost: the surfaces that should overlap lie apart" in words
