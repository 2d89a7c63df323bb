"""The review's recording: poses, clouds and colours, that it survives a kill, repeats, stays small."""

import subprocess
import sys
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from orbitscan.processing.results.estimates import MethodResult
from orbitscan.processing.results.status import METHODS, Status
from orbitscan.processing.review import entities
from orbitscan.processing.review.session.recording import SessionReview
from orbitscan.recorder import poses
from tests.processing.review.made_results import (
    EMPTY,
    FAILED,
    STREAMED,
    make_info,
    make_results,
    review_results,
    true_poses,
    write_review,
)
from tests.processing.review.recordings import packed, read_rows, run_rerun

ROOT = Path(__file__).parents[4]


def test_poses_and_clouds_are_those_of_the_results(reviewed):
    path, (views, session) = reviewed
    translations = read_rows(path, "/object/**", "Transform3D:translation")
    clouds = read_rows(path, "/object/**", "Points3D:positions")
    for method in METHODS:
        for result, estimate in zip(views, session.reconstruction[method].views, strict=True):
            entity = entities.view_path(method, result.view)
            T_0_i = estimate.T_0_i
            if T_0_i is None:
                assert entity not in translations
                continue
            assert np.allclose(translations[entity][result.view][0], T_0_i[:3, 3], atol=1e-6)
            cloud = np.array(clouds[f"{entity}/points"][result.view])
            assert np.array_equal(cloud, result.points)
    truth = np.array(translations[entities.view_path("truth", 2)][2][0])
    assert np.allclose(truth, (poses.invert(true_poses(5)[0]) @ true_poses(5)[2])[:3, 3], atol=1e-6)


def test_failed_views_are_red_and_in_words(tmp_path):
    views, session = make_results()
    without = {m: found for m, found in session.reconstruction.items() if m != "refined"}
    path = tmp_path / "review.rrd"
    with SessionReview(path, make_info(5), STREAMED, true_poses(5)) as review:
        for result in views:
            review.add_view(result)
        review.add_session(replace(session, reconstruction=without))
    colors = read_rows(path, "/object/pairwise/**", "Points3D:colors")
    assert colors[f"/object/pairwise/view_{FAILED:03d}/points"][FAILED] == [packed(entities.BAD_COLOR)]
    assert colors["/object/pairwise/view_002/points"][2] != [packed(entities.BAD_COLOR)]
    words = read_rows(path, "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "pairwise places 3 of 5 views with confidence; low_overlap: 3; too_few_points: 4" in words
    assert words.index("view 4 (scan04)") < words.index("view 3 (scan03)")  # not placed at all is worse
    assert "290 with a frame → 90 matches → 40 inliers, overlap 40%" in words
    lines = read_rows(path, "/log", "TextLog:text")["/log"]
    assert set(lines) == {FAILED, EMPTY}  # and the conclusion, at the last view


def test_refined_stands_at_the_end_what_it_leaves_free_in_yellow(reviewed):
    colors = read_rows(reviewed[0], "/object/refined/**", "Points3D:colors")
    assert colors[f"/object/refined/view_{FAILED:03d}/points"][FAILED] == [packed(entities.FREE_COLOR)]
    assert colors["/object/refined/view_002/points"][2] == [packed(entities.view_color(2, 5))]
    labels = read_rows(reviewed[0], "/object/refined/**", "Points3D:labels")
    assert labels == {f"/object/refined/view_{FAILED:03d}/label": {FAILED: ["view 3: ambiguous"]}}


def test_views_that_refined_does_not_place_are_taken_away(tmp_path):
    views, session = make_results()
    found = session.reconstruction["refined"]
    lost = tuple(replace(v, status=Status.NOT_CONNECTED, T_0_i=None) if v.view == FAILED else v for v in found.views)
    session = replace(session, reconstruction={**session.reconstruction, "refined": replace(found, views=lost)})
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        for result in views:
            review.add_view(result)
        review.add_session(session)
    cleared = read_rows(tmp_path / "review.rrd", "/object/**", "Clear:is_recursive")
    assert cleared[entities.view_path("refined", FAILED)] == {FAILED: [True]}
    assert set(cleared) == {entities.view_path("refined", FAILED)}  # nothing is drawn of a view without points


def test_where_another_view_gives_the_frame_all_is_drawn_anew(tmp_path):
    """View 0 turns out to fit nothing: the poses, the truth and the errors are those in view 1's frame."""
    views, session = make_results()
    back = poses.invert(session.reconstruction["pairwise"].views[1].T_0_i)
    moved = {}
    for method, found in session.reconstruction.items():
        estimates = [replace(v, T_0_i=back @ v.T_0_i) if v.view in (1, 2, 3) else v for v in found.views]
        estimates[0] = replace(estimates[0], status=Status.NOT_CONNECTED, T_0_i=None)
        estimates[FAILED] = replace(estimates[FAILED], status=Status.OK if method == "icp" else Status.LOW_OVERLAP)
        moved[method] = replace(found, views=tuple(estimates))
    path = tmp_path / "review.rrd"
    with SessionReview(path, make_info(5), METHODS, true_poses(5)) as review:
        for result in views:
            review.add_view(result)
        review.add_session(replace(session, reconstruction=moved, origin=1))
    translations = read_rows(path, "/object/**", "Transform3D:translation")
    truth = true_poses(5)
    for method in METHODS:
        T_0_2 = moved[method].views[2].T_0_i
        assert np.allclose(translations[entities.view_path(method, 2)][2][0], T_0_2[:3, 3], atol=1e-6)
    shown = translations[entities.view_path("truth", 2)][2][0]
    assert np.allclose(shown, (poses.invert(truth[1]) @ truth[2])[:3, 3], atol=1e-6)
    cleared = read_rows(path, "/object/**", "Clear:is_recursive")
    label = f"{entities.view_path('icp', FAILED)}/label"
    assert set(cleared) == {label, *(entities.view_path(method, 0) for method in METHODS)}
    colors = read_rows(path, "/object/icp/**", "Points3D:colors")
    assert colors[entities.cloud_path("icp", FAILED)][FAILED] == [packed(entities.view_color(FAILED, 5))]
    curves = read_rows(path, "/errors_again/**", "Scalars:scalars")
    assert set(curves["/errors_again/translation_m/pairwise"]) == {0, 1, 2, 3}
    assert "Frame {0} is that of view 1." in read_rows(path, "/summary", "TextDocument:text")["/summary"][-1][0]


def test_only_refined_asked_for_shows_pairwise_until_it_is_known(tmp_path):
    views, session = make_results()
    only = replace(session, reconstruction={"refined": session.reconstruction["refined"]})
    with SessionReview(tmp_path / "review.rrd", make_info(5), ["refined"], true_poses(5)) as review:
        for result in views:
            review.add_view(result)
        review.add_session(only)
    translations = read_rows(tmp_path / "review.rrd", "/object/**", "Transform3D:translation")
    assert entities.view_path("pairwise", 1) in translations
    assert entities.view_path("refined", 1) in translations
    curves = read_rows(tmp_path / "review.rrd", "/errors/**", "Scalars:scalars")
    assert {path.rsplit("/", 1)[1] for path in curves} == {"refined"}


def test_lesser_clouds_are_thinned(tmp_path):
    write_review(tmp_path / "review.rrd", points=10_000)
    clouds = read_rows(tmp_path / "review.rrd", "/object/**", "Points3D:positions")
    assert len(clouds["/object/refined/view_001/points"][1]) == 10_000
    assert len(clouds["/object/pairwise/view_001/points"][1]) == 2500
    assert len(clouds["/object/icp/view_001/points"][1]) == 2500


def test_captured_colors_are_kept(tmp_path):
    write_review(tmp_path / "review.rrd", colored=True)
    colors = read_rows(tmp_path / "review.rrd", "/object/refined/**", "Points3D:colors")
    assert set(colors["/object/refined/view_002/points"][2]) == {0x5C5C5CFF}


def test_recording_names_itself_and_carries_its_layout(reviewed):
    reader = RrdReader(reviewed[0])
    (recording,) = reader.recordings()
    assert (recording.application_id, recording.recording_id) == ("orbitscan-bumpy_sphere",) * 2
    assert len(reader.blueprints()) == 2  # while it grows, and at the end, which the viewer takes


def test_an_identity_tells_sessions_of_one_name_apart(tmp_path):
    for identity in ("a1", "b2"):
        review_results(tmp_path / f"{identity}.rrd", make_results(), identity=identity)
    found = [RrdReader(tmp_path / f"{identity}.rrd").recordings()[0] for identity in ("a1", "b2")]
    assert [recording.recording_id for recording in found] == [f"orbitscan-bumpy_sphere-{i}" for i in ("a1", "b2")]


def test_without_truth_there_are_no_errors(tmp_path):
    write_review(tmp_path / "review.rrd", with_truth=False)
    content = {chunk.entity_path for chunk in RrdReader(tmp_path / "review.rrd").stream()}
    assert not [path for path in content if path.startswith(("/errors", "/object/truth"))]
    assert "/evidence/overlap/pairwise" in content


def test_session_without_any_placed_view_is_written(tmp_path):
    views, session = make_results(views=5)
    nowhere = views[EMPTY]
    lost = replace(nowhere, origin=None, damage="the chunk's checksum is wrong")
    only = {m: MethodResult((lost.poses["pairwise"],), ()) for m in METHODS}
    empty = {"views_used": (EMPTY,), "view_names": ("scan04",), "stamps_ns": (5,), "reconstruction": only}
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        review.add_view(lost)
        review.add_session(replace(session, **empty, model=None, turntable=None, coverage=None))
    assert run_rerun("rrd", "verify", tmp_path / "review.rrd").returncode == 0
    assert len(RrdReader(tmp_path / "review.rrd").blueprints()) == 1


def test_killed_run_is_readable_up_to_its_last_view(tmp_path):
    script = f"""
import os
from pathlib import Path
from tests.processing.review.made_results import METHODS, SessionReview, make_info, make_results, true_poses
views, _ = make_results()
review = SessionReview(Path({str(tmp_path / "cut.rrd")!r}), make_info(5), METHODS, true_poses(5))
for result in views[:3]:
    review.add_view(result)
os._exit(9)
"""
    assert subprocess.run([sys.executable, "-c", script], cwd=ROOT).returncode == 9
    with pytest.warns(match="footer"):
        curves = read_rows(tmp_path / "cut.rrd", "/errors/**", "Scalars:scalars")
    assert sorted(curves["/errors/translation_m/pairwise"]) == [0, 1, 2]
    with pytest.warns(match="footer"):
        texts = read_rows(tmp_path / "cut.rrd", "/summary", "TextDocument:text")
    assert "Not finished" in texts["/summary"][-1][0]


def test_recording_verifies(reviewed):
    result = run_rerun("rrd", "verify", reviewed[0])
    assert result.returncode == 0, result.stderr


def test_same_results_give_the_same_recording(reviewed, tmp_path):
    write_review(tmp_path / "again.rrd")
    result = run_rerun("rrd", "compare", reviewed[0], tmp_path / "again.rrd")
    assert result.returncode == 0, result.stderr
    write_review(tmp_path / "other.rrd", points=1999)
    assert run_rerun("rrd", "compare", reviewed[0], tmp_path / "other.rrd").returncode == 1


def test_no_cloud_is_kept(tmp_path):
    views, _ = make_results(points=30_000)
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        for result in views[:3]:
            cloud = result.points.copy()
            kept = weakref.ref(cloud)
            review.add_view(replace(result, points=cloud))
            del cloud
            assert kept() is None


def test_size_is_bounded(tmp_path):
    views, session = make_results(views=18, points=30_000, colored=True)
    whole = np.concatenate([view.points for view in views])  # a model as large as all views together
    model = replace(session.model, points=whole, colors=np.full(whole.shape, 90, np.uint8))
    review_results(tmp_path / "large.rrd", (views, replace(session, model=model)), truth=true_poses(18))
    assert (tmp_path / "large.rrd").stat().st_size < 50e6


def test_a_cloud_is_in_the_file_once(tmp_path):
    sizes = []
    for points in (5000, 25_000):
        write_review(tmp_path / "review.rrd", points=points, colored=True)
        sizes.append((tmp_path / "review.rrd").stat().st_size)
    more = (sizes[1] - sizes[0]) / (4 * 20_000)  # the fifth view has no points
    assert 16 <= more < 25  # 12 bytes of coordinates, 4 of colour, a quarter of both in the model
