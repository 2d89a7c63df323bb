"""Results as the processing gives them, of a few views of a bumpy sphere, and their review."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from orbitscan.processing.reconstruction.coverage import CoverageSettings, measure_coverage
from orbitscan.processing.results.estimates import (
    Candidate,
    Correspondences,
    Evidence,
    Freedom,
    MethodResult,
    PairErrors,
    PairEstimate,
    ViewErrors,
    ViewEstimate,
)
from orbitscan.processing.results.records import (
    Coverage,
    Model,
    SessionResult,
    Turntable,
    TurntableDeviation,
    ViewResult,
)
from orbitscan.processing.results.status import METHODS, Method, Status
from orbitscan.processing.review.session.recording import SessionReview
from orbitscan.recorder import poses
from orbitscan.recorder.session import SessionInfo

FAILED, EMPTY = 3, 4  # of the five views: one is placed badly, one has no points
DRIFT = {"icp": 1e-2, "ransac_icp": 1e-3, "pairwise": 1e-4, "refined": 1e-5}  # radians and metres a view
STREAMED = METHODS[:3]  # `refined` is known at the end only
AXIS = np.array([0.0, -np.cos(np.radians(30)), -np.sin(np.radians(30))])  # of the turn, in frame {0}
CENTER = np.array([0.0, 0.0, 0.6])
BOUND_DEG, BOUND_M = 0.1, 2e-4  # of a view by `refined` for each view before it
Results = tuple[list[ViewResult], SessionResult]


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
            status = {FAILED: Status.LOW_OVERLAP, EMPTY: Status.TOO_FEW_POINTS}.get(i, Status.OK)
            estimates[method] = _make_estimate(i, method, status, truth, with_truth)
            if i not in (0, EMPTY):
                pairs[method] = make_pair(i, i - 1, status, "icp" not in method, len(cloud))
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
    i: int, method: str, status: Status, truth: dict[int, np.ndarray], with_truth: bool, center_error: bool = False
) -> ViewEstimate:
    drift = DRIFT[method]
    turn = poses.from_quaternion(np.full(3, i * drift), [np.sin(i * drift / 2), 0, 0, np.cos(i * drift / 2)], "")
    if i == EMPTY:
        return ViewEstimate(i, status, None)
    known = (i * drift, 2 * i * drift, 100 * i * drift, 0.5 * i * drift if center_error else None)
    errors = ViewErrors(*known) if with_truth else ViewErrors()
    return ViewEstimate(i, status, poses.invert(truth[0]) @ truth[i] @ turn, errors=errors)


def make_pair(source: int, target: int, status: Status, matched: bool, points: int) -> PairEstimate:
    counts = {"keypoints": 300, "valid_frames": 290, "matches": 90, "inliers": 40} if matched else {}
    seen = {"misfit": 0.9, "violations": 0.01, "unseen": 0.02, "observability": 0.1}
    evidence = Evidence(points=points, rmse_m=1e-3 * source, overlap=1 - 0.2 * source, **counts, **seen)
    candidates = (Candidate("consensus", status, 0.4), Candidate("identity", Status.DIVERGED, 0.1))
    return PairEstimate(source, target, np.eye(4), status, 0.9, evidence, candidates)


def _make_session(results: list[ViewResult], truth: dict[int, np.ndarray], with_truth: bool) -> SessionResult:
    reconstruction = {}
    for method in STREAMED:
        statuses = {result.view: result.poses[method].status for result in results}
        estimates = tuple(_make_estimate(i, method, statuses[i], truth, with_truth, True) for i in statuses)
        pairs = tuple(result.pairs[method] for result in results if method in result.pairs)
        reconstruction[method] = MethodResult.of(estimates, pairs, 0)
    reconstruction[Method.REFINED] = _make_graph(results, truth, with_truth)
    deviations = tuple(TurntableDeviation(i, 0.1 * i - 0.2, 0.01 * i, 1e-4 * i) for i in range(FAILED))
    model = Model(Method.REFINED, results[0].points, None, results[0].points[:7] + 0.05)
    turntable = Turntable(AXIS, CENTER, 20.0, deviations)
    return SessionResult(
        info=make_info(len(results)),
        views_used=tuple(result.view for result in results),
        view_names=tuple(result.name for result in results),
        stamps_ns=tuple(result.stamp_ns for result in results),
        origin=0,
        reconstruction=reconstruction,
        model=model,
        turntable=turntable,
        coverage=_cover(reconstruction[Method.REFINED], model, turntable),
        seconds={"total": 1.5},
        settings={},
        seed=0,
        centroids={},
    )


def _cover(found: MethodResult, model: Model, turntable: Turntable) -> Coverage | None:
    return measure_coverage(found.placed, (0.0, 0.0, 0.0), model, turntable, CoverageSettings())


def _make_graph(results: list[ViewResult], truth: dict[int, np.ndarray], with_truth: bool) -> MethodResult:
    """A chain of pairs and two more: one that the others contradict by 90 degrees, one with a free turn."""
    odd = {FAILED: Status.AMBIGUOUS, EMPTY: Status.TOO_FEW_POINTS}
    statuses = {result.view: odd.get(result.view, Status.OK) for result in results}
    views = tuple(_make_estimate(i, "refined", status, truth, with_truth, True) for i, status in statuses.items())
    views = tuple(
        replace(view, rotation_bound_deg=BOUND_DEG * view.view, center_bound_m=BOUND_M * view.view)
        if view.status == Status.OK
        else view
        for view in views
    )
    T_0 = {view.view: view.T_0_i for view in views}
    turn = Freedom("turn", AXIS, CENTER)
    quarter = poses.from_quaternion(np.zeros(3), [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "")
    pairs = []
    for source, target in ((1, 0), (2, 1), (2, 0), (3, 2)):
        T = poses.invert(T_0[target]) @ T_0[source]
        pair = make_pair(source, target, Status.OK, target == source - 1, 2000)
        pair = replace(pair, T_target_source=T, center=CENTER)
        if (source, target) == (2, 0):
            pair = replace(pair, T_target_source=quarter @ T, status=Status.INCONSISTENT, confidence=0.95)
        if source == FAILED:
            errors = PairErrors(30.0, 0.01, 0.25, 0.001) if with_truth else PairErrors()
            pair = replace(pair, status=Status.AMBIGUOUS, freedoms=(turn,), errors=errors)
        pairs.append(pair)
    return MethodResult.of(views, pairs, 0, loop_closed=True, freedoms=(turn,))


def make_info(views: int) -> SessionInfo:
    return SessionInfo("bumpy_sphere", views=views, capture="circle", elevation_deg=30.0)


def write_review(path: Path, with_truth: bool = True, **options: int) -> Results:
    views, session = make_results(with_truth=with_truth, **options)
    return review_results(path, (views, session), truth=true_poses(len(views)) if with_truth else {})


def review_results(
    path: Path,
    results: Results,
    methods: Sequence[str] = METHODS,
    truth: Mapping[int, np.ndarray] | None = None,
    **options: str,
) -> Results:
    """Writes results to `path` as a run does, view by view, and gives them back."""
    views, session = results
    with SessionReview(path, session.info, methods, truth, **options) as review:
        for result in views:
            review.add_view(result)
        review.add_session(session)
    return results
