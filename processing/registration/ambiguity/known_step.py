"""The user's step: which of the poses that explain a pair is the one by which the camera moved on."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.ambiguity.symmetry import expand
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.unobservable import hold, turn_by_step
from orbitscan.processing.registration.verification import status_of
from orbitscan.processing.results.estimates import Freedom, PairEstimate
from orbitscan.processing.results.status import WRONG_DEG, Status
from orbitscan.processing.results.uncertainty import Uncertainty

STEP = "step"  # the start of a pose that the user's knowledge settled
AGAINST_STEP = "the views decide against the given step"
_DEVIATION_DEG = 0.2  # of a turntable's step that the user knows
_WITHIN = 1.96  # standard deviations, within which 95 % of what has one dimension lies
_MISFIT = 1.5  # times that of the pose without that knowledge: what fits worse contradicts the user


def use_step(pair: PairRegistration, estimate: PairEstimate) -> PairEstimate:
    """Choose, of all that explains a pair, what agrees with the user's step; as it is where the user knows none.

    A pair that no pose of its orbit brings within 5 degrees of the step is `inconsistent`: the views decide against it.
    By what it misses the step, it may be off.
    """
    step_deg = pair.settings.step_deg
    if step_deg is None or not estimate.status.is_believed:
        return estimate
    turn_deg = step_deg * (estimate.source - estimate.target)
    return _allow_for_miss(_choose(pair, estimate, turn_deg), turn_deg, pair.diameter)


def _choose(pair: PairRegistration, estimate: PairEstimate, turn_deg: float) -> PairEstimate:
    if estimate.T_target_source is None:
        return estimate
    free = next((freedom for freedom in estimate.freedoms if freedom.kind == "turn"), None)
    if free is not None:
        return _turn(pair, estimate, free, turn_deg)
    orbit = [turn @ estimate.T_target_source for turn in expand(estimate.symmetries)] + list(estimate.alternatives)
    near = [T for T in orbit if misses_by(T, turn_deg) <= WRONG_DEG]
    if not near:
        return _decided_against(estimate)
    if len(orbit) == 1:
        return estimate
    first, *others = near
    if any(pair.distance(T, first) > 1.0 for T in others):
        return replace(estimate, T_target_source=first, symmetries=(), alternatives=tuple(others))
    refined = pair.align(first)
    status = estimate.status if estimate.freedoms else Status.OK
    known = pair.measure_uncertainty(refined)
    if known is None or not known.is_good(pair.diameter):
        status = Status.AMBIGUOUS
    return replace(
        estimate,
        T_target_source=refined.T_target_source,
        status=status,
        start=STEP,
        information=refined.information,
        center=refined.center,
        symmetries=(),
        alternatives=(),
    ).with_uncertainty(known)


def _allow_for_miss(estimate: PairEstimate, turn_deg: float, diameter: float) -> PairEstimate:
    """An ok estimate, its turn known no better than it meets the step; `ambiguous` where that is too badly."""
    T, covariance, center = estimate.T_target_source, estimate.covariance, estimate.center
    if estimate.status != Status.OK or T is None or covariance is None or center is None:
        return estimate
    turn = Rotation.from_matrix(T[:3, :3]).as_rotvec()
    axis = turn / max(float(np.linalg.norm(turn)), 1e-12)
    least = (np.radians(misses_by(T, turn_deg)) / _WITHIN) ** 2
    wider = covariance.copy()
    wider[:3, :3] += max(0.0, least - float(axis @ covariance[:3, :3] @ axis)) * np.outer(axis, axis)
    known = Uncertainty(wider, center)
    status = Status.OK if known.is_good(diameter) else Status.AMBIGUOUS
    return replace(estimate, status=status).with_uncertainty(known)


def is_refuted(pairs: Sequence[PairEstimate]) -> bool:
    """Whether more of a session's pairs decide against the user's step than go by it."""
    return sum(pair.note == AGAINST_STEP for pair in pairs) > sum(pair.start == STEP for pair in pairs)


def distrust(pair: PairEstimate) -> PairEstimate:
    """A pair where its session refutes the user's step: `inconsistent` if it went by it."""
    return _decided_against(pair) if pair.start == STEP and pair.status.is_believed else pair


def _decided_against(estimate: PairEstimate) -> PairEstimate:
    return replace(estimate, status=Status.INCONSISTENT, note=AGAINST_STEP)


def misses_by(T_target_source: np.ndarray, turn_deg: float) -> float:
    """By how many degrees a pose misses a turn of the camera; positive turns are counterclockwise seen from above."""
    whole = Rotation.from_matrix(T_target_source[:3, :3]).as_rotvec()
    turned = np.degrees(np.linalg.norm(whole)) * (1 if whole[1] <= 0 else -1)  # a camera's y points down
    return float(abs((turned - turn_deg + 180) % 360 - 180))


def _turn(pair: PairRegistration, estimate: PairEstimate, free: Freedom, turn_deg: float) -> PairEstimate:
    """Turn a pose along its free turn to where the step puts it, if the views agree there."""
    belief = pair.settings.judgement
    if estimate.T_target_source is None or estimate.information is None or estimate.center is None:
        return estimate
    T = turn_by_step(estimate.T_target_source, free, turn_deg)
    found, before = pair.verify(T), estimate.evidence.misfit
    close = before is not None and found.misfit <= _MISFIT * before
    if not close or status_of(found, belief, nearly_slides=True) != Status.OK:
        return _decided_against(estimate)
    deviation = np.radians(_DEVIATION_DEG)
    information = hold(estimate.information, estimate.center, free, deviation)
    known = None
    if estimate.covariance is not None:
        held = hold(np.linalg.inv(estimate.covariance), estimate.center, free, deviation)
        known = Uncertainty(np.linalg.inv(held), estimate.center)
    left = tuple(freedom for freedom in estimate.freedoms if freedom is not free)
    is_good = known is not None and known.is_good(pair.diameter)
    return replace(
        estimate,
        T_target_source=T,
        status=Status.AMBIGUOUS if left or not is_good else Status.OK,
        start=STEP,
        information=information,
        freedoms=left,
        symmetries=(),
        alternatives=(),
    ).with_uncertainty(known)
