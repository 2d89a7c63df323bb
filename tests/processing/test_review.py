"""The review: what is written into a recording, that it survives a kill, and that the viewer draws all of it."""

import subprocess
import sys
import weakref
from collections.abc import Iterator
from dataclasses import replace
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
    Freedom,
    MethodResult,
    Model,
    PairErrors,
    PairEstimate,
    SessionResult,
    Turntable,
    TurntableDeviation,
    ViewErrors,
    ViewEstimate,
    ViewResult,
    summarize,
)
from processing.review import entities, summary
from processing.review.edges import count_edges, left_out, strongest
from processing.review.findings import explain, list_joint_findings
from processing.review.layout import Scene
from processing.review.session import SessionReview
from recorder import poses
from recorder.objects.mesh import Mesh
from recorder.session import SessionInfo
from tests import viewer

ROOT = Path(__file__).parents[2]
FAILED, EMPTY = 3, 4  # of the five views: one is placed badly, one has no points
DRIFT = {"icp": 1e-2, "ransac_icp": 1e-3, "pairwise": 1e-4, "refined": 1e-5}  # radians and metres a view
STREAMED = METHODS[:3]  # `refined` is known at the end only
AXIS = np.array([0.0, -np.cos(np.radians(30)), -np.sin(np.radians(30))])  # of the turn, in frame {0}
CENTER = np.array([0.0, 0.0, 0.6])
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
    results: list[ViewResult] = []
    for i in range(views):
        cloud = np.empty((0, 3), np.float32) if i == EMPTY else scan_bumpy_sphere(truth[i], points, rng)
        estimates, pairs = {}, {}
        for method in STREAMED:
            status = {FAILED: "low_overlap", EMPTY: "too_few_points"}.get(i, "ok")
            estimates[method] = _make_estimate(i, method, status, truth, with_truth)
            if i not in (0, EMPTY):
                pairs[method] = _make_pair(i, i - 1, status, "icp" not in method, len(cloud))
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
    return results, _make_session(results, truth, with_truth)


def _make_estimate(
    i: int, method: str, status: str, truth: dict[int, np.ndarray], with_truth: bool, center_error: bool = False
) -> ViewEstimate:
    drift = DRIFT[method]
    turn = poses.from_quaternion(np.full(3, i * drift), [np.sin(i * drift / 2), 0, 0, np.cos(i * drift / 2)], "")
    if i == EMPTY:
        return ViewEstimate(i, status, None)
    known = (i * drift, 2 * i * drift, 100 * i * drift, 0.5 * i * drift if center_error else None)
    errors = ViewErrors(*known) if with_truth else ViewErrors()
    return ViewEstimate(i, status, poses.invert(truth[0]) @ truth[i] @ turn, errors)


def _make_pair(source: int, target: int, status: str, matched: bool, points: int) -> PairEstimate:
    counts = {"keypoints": 300, "valid_frames": 290, "matches": 90, "inliers": 40} if matched else {}
    seen = {"misfit": 0.9, "violations": 0.01, "unseen": 0.02, "observability": 0.1}
    evidence = Evidence(points=points, rmse_m=1e-3 * source, overlap=1 - 0.2 * source, **counts, **seen)
    candidates = (Candidate("consensus", status, 0.4), Candidate("identity", "diverged", 0.1))
    return PairEstimate(source, target, np.eye(4), status, 0.9, evidence, candidates)


def _make_session(results: list[ViewResult], truth: dict[int, np.ndarray], with_truth: bool) -> SessionResult:
    reconstruction = {}
    for method in STREAMED:
        statuses = {result.view: result.poses[method].status for result in results}
        estimates = tuple(_make_estimate(i, method, statuses[i], truth, with_truth, True) for i in statuses)
        pairs = tuple(result.pairs[method] for result in results if method in result.pairs)
        reconstruction[method] = MethodResult(estimates, pairs, summary=summarize(estimates, 0))
    reconstruction["refined"] = _make_graph(results, truth, with_truth)
    deviations = tuple(TurntableDeviation(i, 0.1 * i - 0.2, 0.01 * i, 1e-4 * i) for i in range(FAILED))
    return SessionResult(
        info=make_info(len(results)),
        views_used=tuple(result.view for result in results),
        view_names=tuple(result.name for result in results),
        stamps_ns=tuple(result.stamp_ns for result in results),
        origin=0,
        reconstruction=reconstruction,
        model=Model("refined", results[0].points, None, results[0].points[:7] + 0.05),
        turntable=Turntable(AXIS, CENTER, 20.0, deviations),
        seconds={"total": 1.5},
        settings={},
        seed=0,
        centroids={},
    )


def _make_graph(results: list[ViewResult], truth: dict[int, np.ndarray], with_truth: bool) -> MethodResult:
    """A chain of pairs and two more: one that the others contradict by 90 degrees, one with a free turn."""
    statuses = {r.view: {FAILED: "ambiguous", EMPTY: "too_few_points"}.get(r.view, "ok") for r in results}
    views = tuple(_make_estimate(i, "refined", status, truth, with_truth, True) for i, status in statuses.items())
    T_0 = {view.view: view.T_0_i for view in views}
    turn = Freedom("turn", AXIS, CENTER)
    quarter = poses.from_quaternion(np.zeros(3), [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "")
    pairs = []
    for source, target in ((1, 0), (2, 1), (2, 0), (3, 2)):
        T = poses.invert(T_0[target]) @ T_0[source]
        pair = replace(_make_pair(source, target, "ok", target == source - 1, 2000), T_target_source=T, center=CENTER)
        if (source, target) == (2, 0):
            pair = replace(pair, T_target_source=quarter @ T, status="inconsistent", confidence=0.95)
        if source == FAILED:
            errors = PairErrors(30.0, 0.01, 0.25, 0.001) if with_truth else PairErrors()
            pair = replace(pair, status="ambiguous", freedoms=(turn,), errors=errors)
        pairs.append(pair)
    return MethodResult(views, tuple(pairs), True, (turn,), summarize(views, 0))


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


def read_all(path: Path, content: str, column: str) -> list:
    """The first item of every cell, several at one view included."""
    batches = [chunk.to_record_batch() for chunk in RrdReader(path).stream().filter(content=content)]
    return [cell[0] for batch in batches if column in batch.schema.names for cell in batch.column(column).to_pylist()]


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
    assert evidence["/evidence/violations/refined"] == {1: [0.01], 2: [0.01], 3: [0.01]}
    assert {path.split("/")[2] for path in evidence} <= set(entities.EVIDENCE)  # each has a title
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


def packed(color: entities.Color) -> int:
    """A colour as Rerun keeps it."""
    return int.from_bytes(bytes([*color, 255]), "big")


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
    lost = tuple(replace(v, status="not_connected", T_0_i=None) if v.view == FAILED else v for v in found.views)
    session = replace(session, reconstruction={**session.reconstruction, "refined": replace(found, views=lost)})
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        for result in views:
            review.add_view(result)
        review.add_session(session)
    cleared = read_rows(tmp_path / "review.rrd", "/object/**", "Clear:is_recursive")
    assert cleared[entities.view_path("refined", FAILED)] == {FAILED: [True]}
    assert set(cleared) == {entities.view_path("refined", view) for view in (FAILED, EMPTY)}


def test_graph_is_drawn_between_the_cameras(reviewed):
    path, (_, session) = reviewed
    strips = read_rows(path, "/graph/**", "LineStrips3D:strips")
    colors = read_rows(path, "/graph/**", "LineStrips3D:colors")
    T_0 = {view.view: view.T_0_i for view in session.reconstruction["refined"].views}
    assert {entity: list(cells) for entity, cells in strips.items()} == {f"/graph/view_00{i}": [i] for i in (1, 2, 3)}
    ends = [[T_0[source][:3, 3], T_0[target][:3, 3]] for source, target in ((2, 1), (2, 0))]
    assert np.allclose(np.array(strips["/graph/view_002"][2]), ends, atol=1e-6)
    assert colors["/graph/view_002"][2] == [packed(entities.GOOD_COLOR), packed(entities.BAD_COLOR)]
    assert colors["/graph/view_003"][3] == [packed(entities.FREE_COLOR)]


def test_a_view_is_spoken_for_by_its_best_edge_that_nothing_contradicts(reviewed):
    found = reviewed[1][1].reconstruction["refined"]
    assert {view: pair.target for view, pair in strongest(found.pairs).items()} == {1: 0, 2: 1, 3: 2}
    assert count_edges(found.pairs) == {0: 1, 1: 2, 2: 2, 3: 1}
    curve = read_rows(reviewed[0], "/evidence/edges/**", "Scalars:scalars")["/evidence/edges/refined"]
    assert curve == {0: [1.0], 1: [2.0], 2: [2.0], 3: [1.0]}


def test_an_edge_that_the_graph_leaves_out_is_a_line_of_the_log(reviewed):
    path, (_, session) = reviewed
    ((pair, disagreement),) = left_out(session.reconstruction["refined"])
    assert (pair.source, pair.target) == (2, 0)
    assert disagreement.degrees == pytest.approx(90)
    assert disagreement.metres == pytest.approx(0, abs=1e-9)  # the quarter turn is about the line of sight
    findings = [text for view, _, text in list_joint_findings(session) if view == 2]
    assert findings == [
        next(text for text in findings if "pair 2 to 0 is left out: the others contradict it by 90°" in text)
    ]
    assert findings[0] in read_all(path, "/log", "TextLog:text")


def test_turntable_is_drawn_and_plotted(reviewed):
    path, (_, session) = reviewed
    (origin,) = read_rows(path, "/turntable/axis", "Arrows3D:origins")["/turntable/axis"][-1]
    (vector,) = read_rows(path, "/turntable/axis", "Arrows3D:vectors")["/turntable/axis"][-1]
    assert np.allclose(np.cross(vector, AXIS), 0, atol=1e-6)
    assert np.dot(vector, AXIS) > 0
    assert np.linalg.norm(np.cross(CENTER - origin, AXIS)) < 1e-6
    curves = read_rows(path, "/turntable/**", "Scalars:scalars")
    for quantity, field, factor in (
        ("slip_deg", "slip_deg", 1),
        ("wobble_deg", "wobble_deg", 1),
        ("shift_mm", "shift_m", 1e3),
    ):
        expected = {d.view: [pytest.approx(factor * getattr(d, field))] for d in session.turntable.deviations}
        assert curves[f"/turntable/{quantity}/refined"] == expected


def test_free_motion_is_dashed_along_its_axis(reviewed):
    strips = read_rows(reviewed[0], "/free/**", "LineStrips3D:strips")["/free/00"][-1]
    points = np.array([point for strip in strips for point in strip])
    off = np.linalg.norm(np.cross(points - CENTER, AXIS), axis=1)
    assert (off < 1e-6).sum() >= 40
    ring = off[off >= 1e-6]
    assert len(ring) >= 40
    assert np.allclose(ring, ring[0], rtol=1e-4)


def test_summary_says_what_cannot_be_told_and_what_turned(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "refined places 3 of 5 views with confidence; ambiguous: 3; too_few_points: 4. The loop is closed." in words
    assert "20.00° from view to view, the camera going counterclockwise seen from above" in words
    assert "leans 30.00° off the first view's upright" in words
    assert "slips by 0.2° (view 0), wobbles by 0.02° (view 2) and shifts by 0.2 mm (view 2)" in words
    assert "a turn about the axis (0.00, -0.87, -0.50) through (0, 0, 600) mm (view 3)" in words
    assert "`--step-deg N` uses your knowledge" in words
    assert "1 of 4 pairs are left out of the graph" in words
    assert "Off by 30°, by 0.25° with that granted" in words
    table = read_rows(reviewed[0], "/table", "TextDocument:text")["/table"][-1][0]
    assert "observable [deg]" in table


def test_the_remedy_is_not_named_again_where_it_was_used(reviewed):
    found = reviewed[1][1].reconstruction["refined"]
    assert "does not fit these views" in summary.describe_freedoms(found, step_was_given=True)
    held = replace(found, views=found.views[:FAILED], freedoms=())  # by other pairs: that one is free tells nothing
    assert summary.describe_freedoms(held, step_was_given=False) == ""


def test_alternatives_are_named_by_their_turn():
    half_turn = poses.from_quaternion(np.zeros(3), [0, 1, 0, 0], "")
    pair = replace(_make_pair(1, 0, "ambiguous", True, 2000), alternatives=(half_turn,))
    assert "As good when turned by 180°" in explain(ViewEstimate(1, "ambiguous", np.eye(4)), pair)


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


def test_mesh_is_drawn(tmp_path):
    views, session = make_results()
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]]), np.full((3, 3), 90, np.uint8))
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        for result in views:
            review.add_view(result)
        review.add_session(replace(session, model=replace(session.model, mesh=mesh)))
    normals = read_rows(tmp_path / "review.rrd", "/model/mesh", "Mesh3D:vertex_normals")["/model/mesh"][-1]
    assert np.allclose(np.array(normals), 1 / np.sqrt(3))


def test_frustum_of_a_range_scanner_stands_nearer():
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3))
    far = Scene.around(points, None, (0.0, 0.0, -50.0))
    assert np.linalg.norm(far.sensor - far.center) == pytest.approx(3 * far.diameter)
    assert np.array_equal(Scene.around(points, None, (0.0, 0.0, 0.0)).sensor, np.zeros(3))
    assert Scene.around(points, None, None).sensor is None


def test_matches_are_drawn_between_two_clouds(reviewed):
    path, _ = reviewed
    strips = read_rows(path, "/pairs/**", "LineStrips3D:strips")
    assert len(strips["/pairs/000_001/inliers"][1]) == 40
    assert len(strips["/pairs/000_001/matches"][1]) == 50


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
    assert (recording.application_id, recording.recording_id) == ("orbitscan", "orbitscan-bumpy_sphere")
    assert len(reader.blueprints()) == 2  # while it grows, and at the end, which the viewer takes


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
        review.add_session(replace(session, **empty, model=None, turntable=None))
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
    assert {"Object by refined", "Object by icp", "Graph", "Slip: its turn off a multiple of the step [deg]"} <= names
    assert {"Summary", "Log"} <= names
    assert ("Translation error [m]" in names) == with_truth


@pytest.mark.parametrize("color", [entities.FREE_COLOR, entities.TURNTABLE_COLOR])
def test_marks_are_legible_beside_the_object(color):
    assert contrast(color, entities.BACKGROUND) >= 4.5  # WCAG 2.1, 1.4.3: they are words too


@pytest.mark.parametrize("color", entities.METHOD_COLORS.values())
@pytest.mark.parametrize("background", [(255, 255, 255), (13, 13, 13), entities.BACKGROUND])
def test_methods_are_legible_on_light_and_dark(color, background):
    assert contrast(color, background) >= 3  # WCAG 2.1, 1.4.11


def contrast(color: entities.Color, background: entities.Color) -> float:
    """The contrast ratio of two colours (WCAG 2.1), 1 to 21."""
    bright, dark = sorted((_luminance(color), _luminance(background)), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


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
