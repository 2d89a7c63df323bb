"""The review: what is written into a recording, that it survives a kill, and that the viewer draws all of it."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from processing.results.records import (
    METHODS,
    Candidate,
    Correspondences,
    Evidence,
    MethodResult,
    Model,
    PairEstimate,
    SessionResult,
    ViewErrors,
    ViewEstimate,
    ViewResult,
    summarize,
)
from processing.review import entities
from processing.review.session import SessionReview
from recorder import poses
from recorder.session import SessionInfo
from tests import viewer

ROOT = Path(__file__).parents[2]
FAILED, EMPTY = 3, 4  # of the five views: one is placed badly, one has no points
DRIFT = {"icp": 1e-2, "ransac_icp": 1e-3, "pairwise": 1e-4}  # radians and metres a view
ERROR_FIELDS = {
    "translation_m": "translation_error_m",
    "rotation_chordal": "rotation_error_chordal",
    "rotation_deg": "rotation_error_deg",
    "center_m": "center_error_m",
}

Results = tuple[list[ViewResult], SessionResult]


@pytest.fixture(autouse=True)
def strict() -> Iterator[None]:
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


@pytest.fixture(scope="module")
def reviewed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Results]:
    """A recording with ground truth, and what went into it."""
    path = tmp_path_factory.mktemp("review") / "review.rrd"
    return path, write_review(path)


def true_poses(views: int, distance: float = 0.6) -> dict[int, np.ndarray]:
    """T_object_camera of cameras around the origin, 20 degrees apart, looking down by 30 degrees."""
    truth = {}
    for i in range(views):
        azimuth, elevation = np.radians(20 * i), np.radians(30)
        forward = -np.array(
            [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
        )
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        truth[i] = poses.make(np.stack([right, np.cross(forward, right), forward], axis=1), -distance * forward)
    return truth


def scan_bumpy_sphere(T_object_camera: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Points (N <= count, 3) float32 of the side of a bumpy sphere that faces the camera, in its frame."""
    directions = rng.normal(size=(3 * count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    toward = T_object_camera[:3, 3] / np.linalg.norm(T_object_camera[:3, 3])
    directions = directions[directions @ toward > 0.2][:count]
    radius = 0.1 + 0.01 * np.sin(7 * directions[:, :1]) * np.cos(5 * directions[:, 1:2])
    return poses.transform(poses.invert(T_object_camera), radius * directions).astype(np.float32)


def make_results(views: int = 5, points: int = 2000, with_truth: bool = True, colored: bool = False) -> Results:
    """Results as the processing gives them: drifting estimates, a view placed badly, a view without points."""
    rng = np.random.default_rng(0)
    truth = true_poses(views)
    origin_inverse = poses.invert(truth[0])
    results: list[ViewResult] = []
    for i in range(views):
        cloud = np.empty((0, 3), np.float32) if i == EMPTY else scan_bumpy_sphere(truth[i], points, rng)
        T_0_i = origin_inverse @ truth[i]
        estimates, pairs = {}, {}
        for method, drift in DRIFT.items():
            status = {FAILED: "low_overlap", EMPTY: "too_few_points"}.get(i, "ok")
            turn = poses.from_quaternion(
                np.full(3, i * drift), [np.sin(i * drift / 2), 0, 0, np.cos(i * drift / 2)], ""
            )
            error = ViewErrors(i * drift, 2 * i * drift, 100 * i * drift) if with_truth and i != EMPTY else ViewErrors()
            estimates[method] = ViewEstimate(i, status, None if i == EMPTY else T_0_i @ turn, error)
            if i not in (0, EMPTY):
                counts = (
                    {} if method == "icp" else {"keypoints": 300, "valid_frames": 290, "matches": 90, "inliers": 40}
                )
                evidence = Evidence(points=len(cloud), rmse_m=1e-3 * i, overlap=1 - 0.2 * i, **counts)
                candidates = (Candidate("consensus", status, 0.4), Candidate("identity", "diverged", 0.1))
                pairs[method] = PairEstimate(i, i - 1, np.eye(4), status, 0.9, evidence, candidates)
        matches = None
        if pairs:
            target = results[-1].points
            matches = Correspondences(i, i - 1, cloud[:90], target[:90], np.arange(90) < 40)
        results.append(
            ViewResult(
                view=i,
                name=f"scan{i:02d}",
                stamp_ns=(i + 1) * 10**9,
                points=cloud,
                colors=np.full((len(cloud), 3), 90 + i, np.uint8) if colored else None,
                keypoints=cloud[:300],
                correspondences=matches,
                pairs=pairs,
                poses=estimates,
                seconds={method: {"prepare": 0.02, "icp": 0.03} for method in METHODS},
                origin=0,
            )
        )
    return results, _make_session(results, with_truth)


def _make_session(results: list[ViewResult], with_truth: bool) -> SessionResult:
    reconstruction = {}
    for method, drift in DRIFT.items():
        estimates = []
        for result in results:
            estimate = result.poses[method]
            e = estimate.errors
            known = e.translation_error_m is not None
            errors = ViewErrors(
                e.translation_error_m,
                e.rotation_error_chordal,
                e.rotation_error_deg,
                0.5 * drift * result.view if known else None,
            )
            estimates.append(ViewEstimate(estimate.view, estimate.status, estimate.T_0_i, errors))
        pairs = tuple(result.pairs[method] for result in results if method in result.pairs)
        reconstruction[method] = MethodResult(tuple(estimates), pairs, summary=summarize(tuple(estimates), 0))
    return SessionResult(
        info=make_info(len(results)),
        views_used=tuple(result.view for result in results),
        view_names=tuple(result.name for result in results),
        stamps_ns=tuple(result.stamp_ns for result in results),
        origin=0,
        reconstruction=reconstruction,
        model=Model("pairwise", results[0].points, None, results[0].points[:7] + 0.05),
        seconds={"total": 1.5},
        settings={},
        seed=0,
        centroids={},
    )


def make_info(views: int) -> SessionInfo:
    return SessionInfo("bumpy_sphere", views=views, capture="circle", elevation_deg=30.0)


def write_review(path: Path, with_truth: bool = True, **options: int) -> Results:
    views, session = make_results(with_truth=with_truth, **options)
    with SessionReview(path, make_info(len(views)), METHODS, true_poses(len(views)) if with_truth else {}) as review:
        for result in views:
            review.add_view(result)
        review.add_session(session)
    return views, session


def read_rows(path: Path, content: str, column: str) -> dict[str, dict[int, list]]:
    """Entity -> recorded index -> cell; a static cell is at -1."""
    rows: dict[str, dict[int, list]] = {}
    for chunk in RrdReader(path).stream().filter(content=content):
        batch = chunk.to_record_batch()
        if column in batch.schema.names:
            times = batch.column("view").to_pylist() if "view" in batch.schema.names else [-1] * batch.num_rows
            rows.setdefault(chunk.entity_path, {}).update(zip(times, batch.column(column).to_pylist(), strict=True))
    return rows


def run_rerun(*arguments: object) -> subprocess.CompletedProcess:
    return subprocess.run([viewer.RERUN, *map(str, arguments)], capture_output=True, text=True)


def test_error_curves_read_back_equal_the_results(reviewed):
    path, (_, session) = reviewed
    curves = read_rows(path, "/errors/**", "Scalars:scalars")
    assert len(curves) == len(METHODS) * len(ERROR_FIELDS)
    for method, found in session.reconstruction.items():
        for quantity, field in ERROR_FIELDS.items():
            expected = {v.view: getattr(v.errors, field) for v in found.views if getattr(v.errors, field) is not None}
            assert {view: cell[0] for view, cell in curves[f"/errors/{quantity}/{method}"].items()} == expected


def test_logarithms_are_of_millimetres_and_leave_the_origin_out(reviewed):
    path, _ = reviewed
    curve = read_rows(path, "/errors_log10/**", "Scalars:scalars")["/errors_log10/translation_mm/icp"]
    assert sorted(curve) == [1, 2, 3]
    assert curve[1][0] == pytest.approx(1.0)  # 10 mm


def test_evidence_and_timing_are_there(reviewed):
    path, _ = reviewed
    evidence = read_rows(path, "/evidence/**", "Scalars:scalars")
    assert evidence["/evidence/overlap/pairwise"] == {1: [0.8], 2: [0.6], 3: [pytest.approx(0.4)]}
    assert "/evidence/inliers/icp" not in evidence
    assert read_rows(path, "/timing/**", "Scalars:scalars")["/timing/total/icp"][2] == [0.05]


def test_stamps_are_those_of_the_views(reviewed):
    path, (views, _) = reviewed
    chunks = [c for c in RrdReader(path).stream().filter(content="/errors/**") if not c.is_static]
    for chunk in chunks:
        batch = chunk.to_record_batch()
        assert set(chunk.timeline_names) == {"view", "stamp"}
        stamps = batch.column("stamp").cast("int64").to_pylist()
        assert stamps == [views[view].stamp_ns for view in batch.column("view").to_pylist()]


def test_poses_and_clouds_are_those_of_the_results(reviewed):
    path, (views, _) = reviewed
    translations = read_rows(path, "/object/**", "Transform3D:translation")
    clouds = read_rows(path, "/object/**", "Points3D:positions")
    for result in views:
        for method in METHODS:
            entity = entities.view_path(method, result.view)
            T_0_i = result.poses[method].T_0_i
            if T_0_i is None:
                assert entity not in translations
                continue
            assert np.allclose(translations[entity][result.view][0], T_0_i[:3, 3], atol=1e-6)
            cloud = np.array(clouds[f"{entity}/points"][result.view])
            assert np.array_equal(cloud, result.points)
    truth = np.array(translations[entities.view_path("truth", 2)][2][0])
    assert np.allclose(truth, (poses.invert(true_poses(5)[0]) @ true_poses(5)[2])[:3, 3], atol=1e-6)


def test_failed_views_are_red_and_in_words(reviewed):
    path, _ = reviewed
    colors = read_rows(path, "/object/pairwise/**", "Points3D:colors")
    red = int.from_bytes(bytes([*entities.BAD_COLOR, 255]), "big")
    assert colors[f"/object/pairwise/view_{FAILED:03d}/points"][FAILED] == [red]
    assert colors["/object/pairwise/view_002/points"][2] != [red]
    summary = read_rows(path, "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "pairwise places 3 of 5 views with confidence; not ok: 3, 4" in summary
    assert summary.index("view 4 (scan04)") < summary.index("view 3 (scan03)")  # not placed at all is worse
    assert "290 with a frame → 90 matches → 40 inliers, overlap 40%" in summary
    lines = read_rows(path, "/log", "TextLog:text")["/log"]
    assert set(lines) == {FAILED, EMPTY}  # and the conclusion, at the last view


def test_matches_are_drawn_between_two_clouds(reviewed):
    path, _ = reviewed
    strips = read_rows(path, "/pairs/**", "LineStrips3D:strips")
    assert len(strips["/pairs/000_001/inliers"][1]) == 40
    assert len(strips["/pairs/000_001/matches"][1]) == 50


def test_lesser_clouds_are_thinned(tmp_path):
    write_review(tmp_path / "review.rrd", points=10_000)
    clouds = read_rows(tmp_path / "review.rrd", "/object/**", "Points3D:positions")
    assert len(clouds["/object/pairwise/view_001/points"][1]) == 10_000
    assert len(clouds["/object/icp/view_001/points"][1]) == 2500


def test_captured_colors_are_kept(tmp_path):
    write_review(tmp_path / "review.rrd", colored=True)
    colors = read_rows(tmp_path / "review.rrd", "/object/pairwise/**", "Points3D:colors")
    assert set(colors["/object/pairwise/view_002/points"][2]) == {0x5C5C5CFF}


def test_recording_names_itself_and_carries_its_layout(reviewed):
    reader = RrdReader(reviewed[0])
    (recording,) = reader.recordings()
    assert (recording.application_id, recording.recording_id) == ("orbitscan", "orbitscan-bumpy_sphere")
    assert len(reader.blueprints()) == 1


def test_without_truth_there_are_no_errors(tmp_path):
    write_review(tmp_path / "review.rrd", with_truth=False)
    content = {chunk.entity_path for chunk in RrdReader(tmp_path / "review.rrd").stream()}
    assert not [path for path in content if path.startswith(("/errors", "/object/truth"))]
    assert "/evidence/overlap/pairwise" in content


def test_session_without_any_placed_view_is_written(tmp_path):
    views, session = make_results(views=5)
    nowhere = views[EMPTY]
    lost = ViewResult(**{**vars(nowhere), "origin": None, "damage": "the chunk's checksum is wrong"})
    only = {m: MethodResult((lost.poses[m],), ()) for m in METHODS}
    empty = {"views_used": (EMPTY,), "view_names": ("scan04",), "stamps_ns": (5,), "reconstruction": only}
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        review.add_view(lost)
        review.add_session(SessionResult(**{**vars(session), **empty, "model": None}))
    assert run_rerun("rrd", "verify", tmp_path / "review.rrd").returncode == 0
    assert len(RrdReader(tmp_path / "review.rrd").blueprints()) == 1


def test_killed_run_is_readable_up_to_its_last_view(tmp_path):
    script = f"""
import os
from pathlib import Path
from tests.processing.test_review import METHODS, SessionReview, make_info, make_results, true_poses
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


def test_size_is_bounded(tmp_path):
    write_review(tmp_path / "large.rrd", views=18, points=30_000, colored=True)
    assert (tmp_path / "large.rrd").stat().st_size < 50e6


@pytest.mark.parametrize("with_truth", [True, False])
def test_viewer_draws_everything(with_truth, tmp_path):
    write_review(tmp_path / "review.rrd", with_truth=with_truth)
    try:
        with viewer.open_viewer(tmp_path / "review.rrd", size="960x540") as client:
            names = {view.name for view in client.get_state().views}
            assert viewer.find_reports(client) == []
    except viewer.NoViewer as reason:
        pytest.skip(str(reason))
    assert {"Object by pairwise", "Object by icp", "Summary", "Log"} <= names
    assert ("Translation error [m]" in names) == with_truth


@pytest.mark.parametrize("color", entities.METHOD_COLORS.values())
@pytest.mark.parametrize("background", [(255, 255, 255), (13, 13, 13), entities.BACKGROUND])
def test_methods_are_legible_on_light_and_dark(color, background):
    bright, dark = sorted((_luminance(color), _luminance(background)), reverse=True)
    assert (bright + 0.05) / (dark + 0.05) >= 3  # WCAG 2.1, 1.4.11


def _luminance(color: entities.Color) -> float:
    c = np.array(color) / 255
    return float(np.where(c <= 0.03928, c / 12.92, ((c + 0.055) / 1.055) ** 2.4) @ (0.2126, 0.7152, 0.0722))


def test_viewer_helper_finds_what_cannot_be_drawn(tmp_path):
    tabs = rrb.Tabs(rrb.TextDocumentView(origin="/words"), rrb.Spatial3DView(origin="/"))
    with rr.RecordingStream("broken") as stream:
        stream.save(tmp_path / "broken.rrd", default_blueprint=rrb.Blueprint(tabs))
        stream.log("words", rr.TextDocument("in front of the broken view"))
        stream.log("here", rr.Points3D([[0, 0, 0]]))
        stream.log("elsewhere", rr.CoordinateFrame("nowhere"), rr.Points3D([[0, 0, 0]]))
    try:
        with viewer.open_viewer(tmp_path / "broken.rrd", size="960x540") as client:
            assert any("No transform path" in report for report in viewer.find_reports(client))
    except viewer.NoViewer as reason:
        pytest.skip(str(reason))
