"""One pair of views by each method: the thesis's and ours."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.registration import verification
from orbitscan.processing.registration.competition import evidence_of, register_from
from orbitscan.processing.registration.hypotheses import propose
from orbitscan.processing.registration.icp import icp
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.registration.ransac import Consensus
from orbitscan.processing.results.records import Correspondences, Evidence, PairEstimate
from orbitscan.processing.results.status import Method, Status


@dataclass(frozen=True, eq=False)
class Matches:
    """Corresponding keypoints of a pair, and the pose most of them agree on."""

    indices: np.ndarray  # (M, 2) of keypoints, source and target
    consensus: Consensus | None


Matched = dict[PreparedView, Matches]  # the matches of one source view, by target


def register_icp(pair: PairRegistration, matches: Matches | None = None) -> PairEstimate:
    """Register a pair by the thesis's point-to-point ICP (4.3) from the matches' consensus; no estimate without one.

    Where no matches are given it starts from the identity: the thesis's baseline (5.2).
    """
    features = None if matches is None else _feature_evidence(pair, matches)
    if matches is None:
        start = np.eye(4)
    elif matches.consensus is None:
        return _no_estimate(pair, matches)
    else:
        start = matches.consensus.T_target_source
    how = pair.settings.refinement
    gate, still = how.icp_gate * pair.w, how.icp_still * pair.diameter
    refined = icp(pair.source.surface.working, pair.target.tree, start, gate, how.icp_iterations, still)
    T = refined.T_target_source
    found, motions = pair.verify(T), pair.find_motions(T)
    status = verification.status_of(found, pair.settings.judgement)
    if status == Status.OK and not motions:
        status = Status.LOW_OVERLAP
    if status == Status.OK and motions[0].information < pair.settings.symmetry.free:
        status = Status.AMBIGUOUS
    confidence = verification.confidence(found, 0.0)
    evidence = evidence_of(pair, refined, found, motions, features)
    return PairEstimate(pair.source.view, pair.target.view, T, status, confidence, evidence)


def register_competing(pair: PairRegistration, matches: Matches, previous: np.ndarray | None) -> PairEstimate:
    """Register a pair our way: starts compete, geometry verifies where they end, the winner is aligned on all surfels.

    The starts are the identity, the previous step of the camera and what the matches propose. Where none of them leads
    to a pose that is believed, more matches and more of their proposals get a second look.
    """
    settings, source, target = pair.settings, pair.source, pair.target
    starts: dict[str, np.ndarray] = {}
    if "identity" in settings.starts:
        starts["identity"] = np.eye(4)
    if "previous" in settings.starts and previous is not None:
        starts["previous"] = previous
    if "consensus" not in settings.starts:
        return _compete(pair, starts, matches)
    if matches.consensus is not None:
        starts["ransac"] = matches.consensus.T_target_source
    first = starts | _name(propose(source, target, matches.indices, settings.proposals))
    best = _compete(pair, first, matches)
    if best.status.is_believed:
        return best
    more = match(source.descriptors, target.descriptors, settings.thorough_matching)
    again = _compete(pair, _name(propose(source, target, more, settings.thorough)), matches)
    return max(best, again, key=lambda estimate: (estimate.status.is_believed, estimate.confidence))


def choose_correspondences(
    source: PreparedView, pairs: Mapping[Method, PairEstimate], matched: Matched
) -> Correspondences | None:
    """Return the matches behind the last of a view's pairs (by method, worst to best) that has any; None without any.

    Each keypoint is in its own view's frame.
    """
    targets = {target.view: target for target in matched}
    chosen = [targets[pair.target] for pair in pairs.values() if pair.target in targets]
    if not chosen:
        return None
    target, matches = chosen[-1], matched[chosen[-1]]
    rows, columns = matches.indices.T
    inlier = np.zeros(len(rows), bool) if matches.consensus is None else matches.consensus.inlier
    return Correspondences(source.view, target.view, source.keypoints[rows], target.keypoints[columns], inlier)


def _compete(pair: PairRegistration, starts: Mapping[str, np.ndarray], matches: Matches) -> PairEstimate:
    return register_from(pair, starts, _feature_evidence(pair, matches)) if starts else _no_estimate(pair, matches)


def _no_estimate(pair: PairRegistration, matches: Matches) -> PairEstimate:
    """An estimate without a pose, whose status says why there is no consensus."""
    status = Status.TOO_FEW_MATCHES if len(matches.indices) < 3 else Status.NO_CONSENSUS
    if min(len(pair.source.keypoints), len(pair.target.keypoints)) < 3:
        status = Status.TOO_FEW_KEYPOINTS
    return PairEstimate(pair.source.view, pair.target.view, None, status, 0.0, _feature_evidence(pair, matches))


def _name(proposed: np.ndarray) -> dict[str, np.ndarray]:
    return {f"consensus {i}": T for i, T in enumerate(proposed)}


def _feature_evidence(pair: PairRegistration, matches: Matches) -> Evidence:
    found = len(matches.indices)
    inliers = 0 if matches.consensus is None else int(matches.consensus.inlier.sum())
    return Evidence(
        points=len(pair.source.surface.working),
        keypoints=len(pair.source.keypoints),
        valid_frames=int(np.isfinite(pair.source.descriptors[:, 0]).sum()),
        matches=found,
        inliers=inliers,
        inlier_ratio=inliers / found if found else 0.0,
    )
