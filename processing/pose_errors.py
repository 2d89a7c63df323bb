"""Estimates against the ground truth (thesis 5.2): the only reader of it beside the review, which draws it."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from orbitscan.processing.registration.ambiguity.symmetry import expand
from orbitscan.processing.registration.unobservable import take_out
from orbitscan.processing.results.estimates import (
    MethodResult,
    PairErrors,
    PairEstimate,
    ViewErrors,
    ViewEstimate,
    summarize,
)
from orbitscan.processing.results.records import SessionResult, ViewResult
from orbitscan.recorder import poses

Truth = Mapping[int, np.ndarray]  # T_object_camera by recorded index


def translation_error(T_true: np.ndarray, T_estimated: np.ndarray) -> float:
    """|| t_grd - t_est || [m] (5.1)."""
    return float(np.linalg.norm(T_true[:3, 3] - T_estimated[:3, 3]))


def rotation_error(T_true: np.ndarray, T_estimated: np.ndarray) -> float:
    """|| I - R_grd R_est^T ||_F (5.2), the chordal distance, 0 to 2 sqrt(2)."""
    return poses.chordal_distance(T_true[:3, :3], T_estimated[:3, :3])


def rotation_error_deg(T_true: np.ndarray, T_estimated: np.ndarray) -> float:
    """The angle [degrees] between two rotations."""
    return float(np.degrees(poses.rotation_angle(T_true[:3, :3] @ T_estimated[:3, :3].T)))


def center_error(T_true: np.ndarray, T_estimated: np.ndarray, center: np.ndarray) -> float:
    """How far apart two poses put the object's centre (3,) [m]: does not grow with the camera's distance."""
    return float(np.linalg.norm(poses.transform(T_true, center[None]) - poses.transform(T_estimated, center[None])))


def with_errors(results: Iterable[ViewResult | SessionResult], truth: Truth) -> Iterator[ViewResult | SessionResult]:
    """The stream of results with errors filled in wherever the truth is known.

    The object's centre is that of all used views, so errors of the centre come with the SessionResult only.
    """
    for result in results:
        yield _of_session(result, truth) if isinstance(result, SessionResult) else _of_view(result, truth)


def _of_view(result: ViewResult, truth: Truth) -> ViewResult:
    return replace(
        result,
        poses={method: _of_pose(pose, truth, result.origin, None) for method, pose in result.poses.items()},
        pairs={method: _of_pair(pair, truth, result.origin, None) for method, pair in result.pairs.items()},
    )


def _of_session(result: SessionResult, truth: Truth) -> SessionResult:
    center = _center(result, truth)

    def evaluate(method: MethodResult) -> MethodResult:
        views = tuple(_of_pose(pose, truth, result.origin, center) for pose in method.views)
        pairs = tuple(_of_pair(pair, truth, result.origin, center) for pair in method.pairs)
        return replace(method, views=views, pairs=pairs, summary=summarize(views, result.origin))

    return replace(result, reconstruction={name: evaluate(method) for name, method in result.reconstruction.items()})


def _of_pose(estimate: ViewEstimate, truth: Truth, origin: int | None, center: np.ndarray | None) -> ViewEstimate:
    T_true = _relative(truth, origin, estimate.view)
    T = estimate.T_0_i
    if T_true is None or T is None:
        return estimate
    errors = ViewErrors(
        translation_error_m=translation_error(T_true, T),
        rotation_error_chordal=rotation_error(T_true, T),
        rotation_error_deg=rotation_error_deg(T_true, T),
        center_error_m=None
        if center is None
        else center_error(T_true, T, poses.transform(poses.invert(T_true), center[None])[0]),
    )
    return replace(estimate, errors=errors)


def _of_pair(pair: PairEstimate, truth: Truth, origin: int | None, center: np.ndarray | None) -> PairEstimate:
    T_true = _relative(truth, pair.target, pair.source)
    T_0_target = _relative(truth, origin, pair.target)
    if T_true is None or pair.T_target_source is None:
        return pair
    center_in_target, known = np.zeros(3), False
    if center is not None and T_0_target is not None:
        center_in_target, known = poses.transform(poses.invert(T_0_target), center[None])[0], True
    off = [T @ poses.invert(T_true) for T in (pair.T_target_source, *pair.alternatives)]
    degrees, metres = _turn_and_shift(off[0], center_in_target)
    turned = [turn @ off[0] for turn in expand(pair.symmetries)]
    granted = (take_out(D, pair.freedoms, center_in_target) for D in (*turned, *off[1:]))
    least_degrees, least_metres = min(_turn_and_shift(D, center_in_target) for D in granted)
    errors = PairErrors(degrees, metres if known else None, least_degrees, least_metres if known else None)
    return replace(pair, errors=errors)


def _turn_and_shift(D: np.ndarray, center: np.ndarray) -> tuple[float, float]:
    """How far a motion turns [degrees] and moves a centre (3,) [m]."""
    return rotation_error_deg(D, np.eye(4)), center_error(D, np.eye(4), center)


def _relative(truth: Truth, target: int | None, source: int) -> np.ndarray | None:
    """The true T_target_source; None where one of the two is unknown."""
    if target is None or target not in truth or source not in truth:
        return None
    return poses.invert(truth[target]) @ truth[source]


def _center(result: SessionResult, truth: Truth) -> np.ndarray | None:
    """The mean in frame {0} of all points of the used views, placed by the truth; (3,) metres."""
    total, count = np.zeros(3), 0
    for view, centroid in result.centroids.items():
        if (T_0_i := _relative(truth, result.origin, view)) is not None:
            total += centroid.points * poses.transform(T_0_i, centroid.mean[None])[0]
            count += centroid.points
    return total / count if count else None
