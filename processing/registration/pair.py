"""One pair of views, source to target, by each method of the thesis and by ours."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.registration import verification
from orbitscan.processing.registration.competition import PairSettings, evidence_of, register_from
from orbitscan.processing.registration.hypotheses import propose
from orbitscan.processing.registration.icp import icp
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.prepared_view import Prepared
from orbitscan.processing.registration.ransac import Consensus
from orbitscan.processing.registration.symmetry import weak_motions
from orbitscan.processing.results.records import Correspondences, Evidence, PairEstimate
from orbitscan.processing.results.status import Status

BELIEVED = (Status.OK, Status.AMBIGUOUS)  # a pose that geometry bears out, though not always it alone


@dataclass(frozen=True, eq=False)
class Matches:
    """Corresponding keypoints of a pair, and the pose most of them agree on."""

    indices: np.ndarray  # (M, 2) of keypoints, source and target
    consensus: Consensus | None


def register_icp(source: Prepared, target: Prepared, settings: PairSettings) -> PairEstimate:
    """The thesis's baseline (5.2): point-to-point ICP from the identity."""
    return _point_to_point(np.eye(4), source, target, settings, {})


def register_consensus(source: Prepared, target: Prepared, found: Matches, settings: PairSettings) -> PairEstimate:
    """The thesis's method (4.2-4.3): the same ICP from the consensus set's pose; no estimate without one."""
    features = _feature_evidence(source, found)
    if found.consensus is None:
        return _no_estimate(source, target, found, features)
    return _point_to_point(found.consensus.T_target_source, source, target, settings, features)


def register_competing(
    source: Prepared, target: Prepared, found: Matches, previous: np.ndarray | None, settings: PairSettings
) -> PairEstimate:
    """Ours: starts compete, geometry judges where alignment takes them, the winner is aligned on all surfels.

    The starts are the identity, the previous step of the camera and what the correspondences propose. Where none of
    them leads to a pose that is believed, more correspondences and more of their proposals get a second look.
    """
    features = _feature_evidence(source, found)
    starts = {name: T for name, T in (("identity", np.eye(4)), ("previous", previous)) if name in settings.starts}
    starts = {name: T for name, T in starts.items() if T is not None}
    if "consensus" not in settings.starts:
        return _compete(starts, source, target, found, settings, features)
    if found.consensus is not None:
        starts["ransac"] = found.consensus.T_target_source
    first = starts | _name(propose(source, target, found.indices, settings.proposals))
    best = _compete(first, source, target, found, settings, features)
    if best.status in BELIEVED:
        return best
    more = match(source.descriptors, target.descriptors, settings.thorough_matching)
    second = _name(propose(source, target, more, settings.thorough))
    again = _compete(second, source, target, found, settings, features)
    return max(best, again, key=lambda pair: (pair.status in BELIEVED, pair.confidence))


def _compete(
    starts: Mapping[str, np.ndarray],
    source: Prepared,
    target: Prepared,
    found: Matches,
    settings: PairSettings,
    features: Mapping[str, float | int],
) -> PairEstimate:
    if not starts:
        return _no_estimate(source, target, found, features)
    return register_from(starts, source, target, settings, features)


def _no_estimate(
    source: Prepared, target: Prepared, found: Matches, features: Mapping[str, float | int]
) -> PairEstimate:
    evidence = Evidence(points=len(source.surface.working), **features)
    return PairEstimate(source.view, target.view, None, _why_no_consensus(source, target, found), 0.0, evidence)


def _name(proposed: np.ndarray) -> dict[str, np.ndarray]:
    return {f"consensus {i}": T for i, T in enumerate(proposed)}


def _point_to_point(
    start: np.ndarray,
    source: Prepared,
    target: Prepared,
    settings: PairSettings,
    features: Mapping[str, float | int],
) -> PairEstimate:
    w, how = source.scale.working, settings.refinement
    still = how.icp_still * source.scale.diameter
    refined = icp(source.surface.working, target.tree, start, how.icp_gate * w, how.icp_iterations, still)
    judged = verification.judge(refined.T_target_source, source, target, settings.judgement)
    motions = weak_motions(refined.T_target_source, source.many, target, settings.judgement.gate * w)
    status = verification.status_of(judged, settings.judgement)
    if status == Status.OK and not motions:
        status = Status.LOW_OVERLAP
    if status == Status.OK and motions[0].information < settings.symmetry.free:
        status = Status.AMBIGUOUS
    return PairEstimate(
        source.view,
        target.view,
        refined.T_target_source,
        status,
        verification.confidence(judged, 0.0),
        evidence_of(source, refined, judged, motions, features),
    )


def _feature_evidence(source: Prepared, found: Matches) -> dict[str, float | int]:
    matches = len(found.indices)
    inliers = 0 if found.consensus is None else int(found.consensus.inlier.sum())
    return {
        "keypoints": len(source.keypoints),
        "valid_frames": int(np.isfinite(source.descriptors[:, 0]).sum()),
        "matches": matches,
        "inliers": inliers,
        "inlier_ratio": inliers / matches if matches else 0.0,
    }


def _why_no_consensus(source: Prepared, target: Prepared, found: Matches) -> str:
    if min(len(source.keypoints), len(target.keypoints)) < 3:
        return Status.TOO_FEW_KEYPOINTS
    return Status.TOO_FEW_MATCHES if len(found.indices) < 3 else Status.NO_CONSENSUS


def last_correspondences(source: Prepared, found: Mapping[Prepared, Matches]) -> Correspondences | None:
    """The matches of a view with the last of its targets, each keypoint in its own view's frame; None without any."""
    if not found:
        return None
    target, matches = list(found.items())[-1]
    pairs = matches.indices
    inlier = np.zeros(len(pairs), bool) if matches.consensus is None else matches.consensus.inlier
    return Correspondences(
        source.view, target.view, source.keypoints[pairs[:, 0]], target.keypoints[pairs[:, 1]], inlier
    )
