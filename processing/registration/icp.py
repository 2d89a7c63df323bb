"""Point-to-point ICP, the thesis's refinement (4.3), and a pair by it."""

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree

from orbitscan.processing.registration import verification
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.ransac import Matches, fit
from orbitscan.processing.registration.surface_icp import Refined
from orbitscan.processing.results.estimates import PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses


def register_icp(pair: PairRegistration, matches: Matches | None = None) -> PairEstimate:
    """Register a pair by the thesis's point-to-point ICP (4.3) from the matches' consensus; no estimate without one.

    Where no matches are given it starts from the identity: the thesis's baseline (5.2).
    """
    features = None if matches is None else pair.feature_evidence(matches)
    if matches is None:
        start = np.eye(4)
    elif matches.consensus is None:
        return pair.give_up(matches)
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
    evidence = pair.gather_evidence(refined, found, motions, features)
    return PairEstimate(pair.source.view, pair.target.view, T, status, confidence, evidence)


def icp(source: np.ndarray, target: cKDTree, start: np.ndarray, gate: float, iterations: int, still: float) -> Refined:
    """Point-to-point ICP (thesis 4.3) of points (N, 3) from a start T_target_source.

    Each point is paired with the nearest target point within the gate [m], the pose fitted to the pairs in closed form
    (4.8)-(4.22), until no step moves a point by more than `still` [m].
    """
    T = start
    for _ in range(iterations):
        moved = poses.transform(T, source)
        distance, nearest = target.query(moved, distance_upper_bound=gate, workers=get_num_threads())
        paired = np.isfinite(distance)
        if paired.sum() < 3:
            return Refined(T, False)
        step = fit(moved[None, paired], target.data[None, nearest[paired]])[0]
        T = step @ T
        if np.abs(poses.transform(step, moved) - moved).max() < still:
            return Refined(T, True)
    return Refined(T, False)
