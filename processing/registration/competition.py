"""A competition of starts: alignment takes each to a pose, geometry verifies the poses and tells the best's rivals."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from orbitscan.processing.registration import verification
from orbitscan.processing.registration.ambiguity.free_motions import find_freedoms
from orbitscan.processing.registration.ambiguity.known_step import STEP, use_step
from orbitscan.processing.registration.ambiguity.orbit import find_orbit
from orbitscan.processing.registration.color.decision import COLOR, doubt_color, use_color, verify_color
from orbitscan.processing.registration.color.proposals import propose_by_color
from orbitscan.processing.registration.hypotheses import propose
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.registration.trials import (
    Trial,
    finish,
    is_believed,
    is_rival,
    keep_distinct,
    put_best_explained_first,
    refine,
    settle,
    start_around,
    try_starts,
    turn_by_itself,
)
from orbitscan.processing.results.estimates import Candidate, Evidence, Freedom, PairEstimate, Symmetry, UsualMisfit
from orbitscan.processing.results.status import Status


def register_competing(
    pair: PairRegistration, matches: Matches, likely: Mapping[str, np.ndarray] | None = None, only_ok: bool = False
) -> PairEstimate:
    """Register a pair our way: starts compete, geometry verifies where they end, the winner is aligned on all surfels.

    The starts are the identity, likely poses T_target_source by their names (`previous`, the camera's last step, only
    where the settings say so) and what the matches propose. Where they lead to no pose that is believed, or to several,
    more matches and more of their proposals get a second look; but where `only_ok` is of use, several poses are not
    looked at further.
    """
    settings, source, target = pair.settings, pair.source, pair.target
    starts = {"identity": np.eye(4)} if "identity" in settings.starts else {}
    starts |= {name: T for name, T in (likely or {}).items() if name != "previous" or name in settings.starts}
    if "consensus" not in settings.starts:
        return _compete(pair, starts, matches)
    if matches.consensus is not None:
        starts["ransac"] = matches.consensus.T_target_source
    first = starts | _name(propose(source, target, matches.indices, settings.proposals), "consensus")
    best = _compete(pair, first, matches)
    several = bool(best.symmetries or best.alternatives) and not only_ok
    if best.status == Status.OK or (best.status.is_believed and not several):
        return best
    more = match(source.descriptors, target.descriptors, settings.thorough_matching)
    thorough = _name(propose(source, target, more, settings.thorough), "consensus")
    thorough |= _name(propose_by_color(source, target, settings), "color")
    if best.status.is_believed and best.T_target_source is not None:
        return _compete(pair, {"first look": best.T_target_source} | thorough, matches)
    again = _compete(pair, thorough, matches)
    return max(best, again, key=lambda estimate: (estimate.status.is_believed, estimate.confidence))


def look(pair: PairRegistration) -> float:
    """Tell how well the best of a pair's starts makes its views agree at a first look (see `Verification.score`)."""
    settings, source, target = pair.settings, pair.source, pair.target
    matches = match(source.descriptors, target.descriptors, settings.thorough_matching)
    starts = {"identity": np.eye(4)} | _name(propose(source, target, matches, settings.proposals), "consensus")
    return max(trial.found.score for trial in try_starts(pair, starts))


def _compete(pair: PairRegistration, starts: Mapping[str, np.ndarray], matches: Matches) -> PairEstimate:
    return register_from(pair, starts, pair.feature_evidence(matches)) if starts else pair.give_up(matches)


def _name(proposed: np.ndarray, kind: str) -> dict[str, np.ndarray]:
    return {f"{kind} {i}": T for i, T in enumerate(proposed)}


def register_from(
    pair: PairRegistration, starts: Mapping[str, np.ndarray], features: Evidence | None = None
) -> PairEstimate:
    """Estimate a pair by the best pose that any of the named starts T_target_source leads to; at least one is needed.

    `features` is the evidence of the correspondences, where there are any. The information and freedoms are of the best
    pose; alternatives are rivals that explain the views as well.
    """
    belief, rivals_at_most = pair.settings.judgement, pair.settings.rivals
    trials = try_starts(pair, starts)
    if around := start_around(pair, trials):
        trials = keep_distinct(pair, [*trials, *try_starts(pair, around)])
        settled = [settle(pair, trial) for trial in trials[:rivals_at_most]]
        trials = keep_distinct(pair, [*settled, *trials[rivals_at_most:]])
    best, *others = put_best_explained_first(pair, refine(pair, trials))
    best = finish(pair, best)
    motions = pair.find_motions(best.T)
    slides = pair.nearly_slides(motions)
    status = verification.status_of(best.found, belief, slides)
    if status == Status.OK and not motions:
        status = Status.LOW_OVERLAP
    freedoms: tuple[Freedom, ...] = ()
    if slides and best.found.score >= belief.min_score:
        freedoms = find_freedoms(pair, best.T, motions)
    rivals = [trial for trial in others if is_rival(pair, trial, best, freedoms)]
    found = PairEstimate(
        pair.source.view,
        pair.target.view,
        best.T,
        status,
        verification.confidence(best.found, max((trial.found.score for trial in rivals), default=0.0)),
        pair.gather_evidence(best.refined, best.found, motions, features),
        tuple(
            Candidate(trial.start, verification.status_of(trial.found, belief), trial.found.score) for trial in trials
        ),
        start=best.start,
        information=best.refined.information,
        center=best.refined.center,
        freedoms=freedoms,
    )
    if status == Status.OK:
        return _settle(pair, use_color(pair, _open(pair, found, best, rivals)))
    if status == Status.INCONSISTENT and pair.is_colored and verification.status_of(best.found, belief) == Status.OK:
        told = use_color(pair, replace(_open(pair, found, best, rivals), status=Status.AMBIGUOUS))
        return _settle(pair, told) if told.start == COLOR else found  # colours hold what slides
    return found


def register_near(pair: PairRegistration, name: str, start: np.ndarray) -> PairEstimate:
    """Estimate a pair by one start T_target_source that other pairs predict; at best `ambiguous` where it may slide.

    Alignment leaves a pose that slides where it was: it would bear out whatever is predicted.
    """
    (trial,) = try_starts(pair, {name: start})
    motions = pair.find_motions(trial.T, coarse=True)
    if not pair.nearly_slides(motions):
        return register_from(pair, {name: start})
    status = verification.status_of(trial.found, pair.settings.judgement)
    return PairEstimate(
        pair.source.view,
        pair.target.view,
        trial.T,
        Status.AMBIGUOUS if status == Status.OK else status,
        verification.confidence(trial.found, 0.0),
        pair.gather_evidence(trial.refined, trial.found, motions, None),
        start=name,
    )


def _open(pair: PairRegistration, found: PairEstimate, best: Trial, rivals: Sequence[Trial]) -> PairEstimate:
    """Return an estimate with all that explains its views as well and how well it is known; `ambiguous` if so."""
    belief = pair.settings.judgement
    turned = turn_by_itself(pair, best, found.freedoms, rivals)
    believed = [trial.T for trial in rivals if is_believed(trial.found, belief)]
    believed += [trial.T for trial in turned if trial.found.violations <= belief.max_violations]
    rivals = keep_distinct(pair, [*rivals, *turned])
    orbit = find_orbit(pair, best.T, believed, found.freedoms)
    known_to = pair.measure_uncertainty(best.refined)
    is_good = known_to is not None and known_to.is_good(pair.diameter)
    return replace(
        found,
        status=Status.OK if orbit.is_single and not found.freedoms and is_good else Status.AMBIGUOUS,
        confidence=verification.confidence(best.found, max((trial.found.score for trial in rivals), default=0.0)),
        freedoms=found.freedoms + orbit.freedoms,
        symmetries=orbit.symmetries,
        alternatives=orbit.alternatives,
        margin=orbit.margin,
    ).with_uncertainty(known_to)


def _settle(pair: PairRegistration, estimate: PairEstimate) -> PairEstimate:
    """What the user's step makes of an estimate, and whether colours and size speak against it."""
    return verify_scale(pair, verify_color(pair, use_step(pair, estimate)))


def challenge(pair: PairRegistration, estimate: PairEstimate, suspected: Sequence[Symmetry]) -> PairEstimate:
    """Return an estimate with those turns of suspected symmetries (target's frame) that explain its views as well."""
    T = estimate.T_target_source
    if T is None or not suspected or not estimate.status.is_believed or estimate.start == STEP:
        return estimate
    orbit = find_orbit(pair, T, estimate.alternatives, estimate.freedoms, [*estimate.symmetries, *suspected])
    if orbit.is_single:
        return estimate
    left = replace(
        estimate,
        status=Status.AMBIGUOUS,
        freedoms=estimate.freedoms + orbit.freedoms,
        symmetries=orbit.symmetries,
        alternatives=orbit.alternatives,
    )
    alike = [symmetry for symmetry in suspected if not symmetry.told_by_color]
    return verify_color(pair, use_step(pair, doubt_color(pair, use_color(pair, left), alike)))


def verify_scale(pair: PairRegistration, estimate: PairEstimate) -> PairEstimate:
    """Return an estimate, as `inconsistent` if it is ok but for the size of its views: no pose makes up for that."""
    if estimate.status != Status.OK or estimate.T_target_source is None:
        return estimate
    difference = pair.measure_scale(estimate.T_target_source)
    if difference is None or not difference.is_certain:
        return estimate
    return replace(estimate, status=Status.INCONSISTENT, note=str(difference))


def verify_usual(pair: PairEstimate, usual: UsualMisfit | None, settings: PairSettings) -> PairEstimate:
    """Return the pair, as `diverged` if it fits clearly less closely than its session's others do.

    A mug upside down agrees with itself up to its handle and rim: no surface contradicts it, it just fits worse.
    """
    observability, misfit = pair.evidence.observability, pair.evidence.misfit
    if not pair.status.is_believed or usual is None or misfit is None:
        return pair
    slides = observability is not None and observability < settings.symmetry.suspicious
    sliding_limit = settings.judgement.sliding_misfit * usual.median if slides else np.inf
    worse = misfit > min(sliding_limit, usual.limit)
    return replace(pair, status=Status.DIVERGED) if worse else pair
