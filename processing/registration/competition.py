"""A competition of starts: alignment takes each to a pose, geometry verifies the poses and tells the best's rivals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orbitscan.processing.registration import verification
from orbitscan.processing.registration.ambiguity import find_freedoms, turn_around
from orbitscan.processing.registration.hypotheses import propose
from orbitscan.processing.registration.known_step import STEP, use_step
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.orbit import Orbit, find_orbit
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.registration.surface_icp import Refined
from orbitscan.processing.registration.unobservable import take_out
from orbitscan.processing.registration.verification import Verification
from orbitscan.processing.results.estimates import Candidate, Evidence, Freedom, PairEstimate, Symmetry, UsualMisfit
from orbitscan.processing.results.status import Status

_SAME_END = 0.3  # of what makes two poses distinct: starts that end so near to each other end in one place
_WORTH = 0.75  # of what is asked of a pose, of a coarse one that is aligned on all surfels
_SETTLING = (1.6, 0.8, 0.8, 0.4, 0.2)  # steps along a weak motion, in what makes two poses distinct


@dataclass(frozen=True, eq=False)
class Trial:
    """A pose that competes: where it started, where it ended, and how far the views agree there."""

    start: str  # its name, see `Candidate`
    refined: Refined
    found: Verification

    @property
    def T(self) -> np.ndarray:
        """T_target_source."""
        return self.refined.T_target_source


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
    if best.status == Status.OK or (best.status.is_believed and not (best.symmetries or best.alternatives)):
        return best
    more = match(source.descriptors, target.descriptors, settings.thorough_matching)
    thorough = _name(propose(source, target, more, settings.thorough))
    if best.status.is_believed and best.T_target_source is not None:
        return _compete(pair, {"first look": best.T_target_source} | thorough, matches)
    again = _compete(pair, thorough, matches)
    return max(best, again, key=lambda estimate: (estimate.status.is_believed, estimate.confidence))


def _compete(pair: PairRegistration, starts: Mapping[str, np.ndarray], matches: Matches) -> PairEstimate:
    return register_from(pair, starts, pair.feature_evidence(matches)) if starts else pair.give_up(matches)


def _name(proposed: np.ndarray) -> dict[str, np.ndarray]:
    return {f"consensus {i}": T for i, T in enumerate(proposed)}


def register_from(
    pair: PairRegistration, starts: Mapping[str, np.ndarray], features: Evidence | None = None
) -> PairEstimate:
    """Estimate a pair by the best pose that any of the named starts T_target_source leads to; at least one is needed.

    `features` is the evidence of the correspondences, where there are any. The information and freedoms are of the best
    pose; alternatives are rivals that explain the views as well.
    """
    belief, rivals_at_most = pair.settings.judgement, pair.settings.rivals
    trials = _try(pair, starts)
    if around := _turn_around(pair, trials):
        trials = _keep_distinct(pair, [*trials, *_try(pair, around)])
        settled = [_settle(pair, trial) for trial in trials[:rivals_at_most]]
        trials = _keep_distinct(pair, [*settled, *trials[rivals_at_most:]])
    best, *others = _put_best_explained_first(pair, _refine(pair, trials))
    motions = pair.find_motions(best.T)
    slides = pair.nearly_slides(motions)
    status = verification.status_of(best.found, belief, slides)
    if status == Status.OK and not motions:
        status = Status.LOW_OVERLAP
    known_to = pair.measure_uncertainty(best.refined) if status == Status.OK else None
    is_good = known_to is not None and known_to.is_good(pair.diameter)
    freedoms: tuple[Freedom, ...] = ()
    if slides and best.found.score >= belief.min_score:
        freedoms = find_freedoms(pair, best.T, motions)
    rivals = [trial for trial in others if _is_rival(pair, trial, best, freedoms)]
    orbit = Orbit()
    if status == Status.OK:
        turned = _turn_by_itself(pair, best, freedoms, rivals)
        believed = [trial.T for trial in rivals if _is_believed(trial.found, belief)]
        believed += [trial.T for trial in turned if trial.found.violations <= belief.max_violations]
        rivals = _keep_distinct(pair, [*rivals, *turned])
        orbit = find_orbit(pair, best.T, believed, freedoms)
        freedoms += orbit.freedoms
    single = not (freedoms or orbit.symmetries or orbit.alternatives)
    if status == Status.OK and not (single and is_good):
        status = Status.AMBIGUOUS
    estimate = PairEstimate(
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
        symmetries=orbit.symmetries,
        alternatives=orbit.alternatives,
        margin=orbit.margin,
    )
    return use_step(pair, estimate.with_uncertainty(known_to))


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
    return use_step(pair, left)


def _is_believed(found: Verification, belief: verification.VerificationSettings) -> bool:
    """Whether a pose would be believed if it were the only one, but for how well it explains what it must."""
    return found.overlap >= belief.min_overlap and found.violations <= belief.max_violations


def _put_best_explained_first(pair: PairRegistration, trials: Sequence[Trial]) -> list[Trial]:
    """Put first the best one of the trials, which come best first, that none of the others explains clearly better.

    What overlaps more is no better for it: a pose is preferred where what both sensors must see decides.
    """
    belief, limit = pair.settings.judgement, pair.settings.covisibility.worse
    likely = [trial for trial in trials if _is_believed(trial.found, belief) and trial.found.score >= belief.min_score]
    if len(likely) < 2:
        return list(trials)
    explained = [pair.explain(trial.T) for trial in likely]
    first = next(
        (k for k, ours in enumerate(explained) if all(ours.worse_than(other) <= limit for other in explained)),
        min(range(len(likely)), key=lambda k: max(explained[k].worse_than(other) for other in explained)),
    )
    return [likely[first], *(trial for trial in trials if trial is not likely[first])]


def _turn_around(pair: PairRegistration, trials: Sequence[Trial]) -> dict[str, np.ndarray]:
    """Return more starts about the best trials that nearly slide: the right pose may be farther along the way."""
    starts: dict[str, np.ndarray] = {}
    for trial in trials[: pair.settings.rivals]:
        motions = pair.find_motions(trial.T, coarse=True)
        if pair.nearly_slides(motions) and trial.found.score >= pair.settings.judgement.min_score:
            around = turn_around(pair, trial.T, motions)
            starts |= {f"{trial.start}, {turn}": T for turn, T in around.items()}
    return starts


def _turn_by_itself(
    pair: PairRegistration, best: Trial, freedoms: Sequence[Freedom], rivals: Sequence[Trial]
) -> list[Trial]:
    """Return where the best pose is led by turns under which one of the two views agrees with itself.

    They need to meet less than others: that what is seen repeats itself speaks for them.
    """
    turned = [best.T @ turn for turn in pair.source.self_turns] + [turn @ best.T for turn in pair.target.self_turns]
    trials: list[Trial] = []
    for T in turned:
        trial = Trial("itself", Refined(T, converged=False), pair.verify(T, coarse=True))
        known = any(not _differ(pair, trial, other) for other in (*rivals, *trials))
        meets = trial.found.overlap >= pair.settings.judgement.min_overlap / 2
        if known or not meets or not _is_rival(pair, trial, best, freedoms):
            continue
        ended = pair.align(T)
        trials.append(Trial("itself", ended, pair.verify(ended.T_target_source)))
    return [trial for trial in trials if _is_rival(pair, trial, best, freedoms)]


def _try(pair: PairRegistration, starts: Mapping[str, np.ndarray]) -> list[Trial]:
    """Align the coarse surfels from each start; the trials come best first, those that end together once."""
    how = pair.settings.refinement
    ends = pair.align_coarsely(np.array(list(starts.values())), how.coarse_gate, how.coarse_deviation)
    trials: list[Trial] = []
    for name, T in zip(starts, ends, strict=True):
        if all(pair.distance(T, other.T) > _SAME_END for other in trials):
            trials.append(Trial(name, Refined(T, converged=False), pair.verify(T, coarse=True)))
    return _keep_distinct(pair, trials)


def _settle(pair: PairRegistration, trial: Trial) -> Trial:
    """Move a trial that nearly slides along its weakest motion to where the views agree best: alignment does not."""
    motions = pair.find_motions(trial.T, coarse=True)
    if not pair.nearly_slides(motions):
        return trial
    unit = motions[0].size(*pair.distinct)
    for size in _SETTLING:
        for sign in (1, -1):
            T = motions[0].pose(sign * size * unit) @ trial.T
            found = pair.verify(T, coarse=True)
            if found.score > trial.found.score:
                trial = Trial(trial.start, Refined(T, converged=False), found)
                break
    return trial


def _refine(pair: PairRegistration, trials: Sequence[Trial]) -> list[Trial]:
    """Refine the trials that come near the best one on all surfels; what is returned is distinct, best first.

    One whose surfaces hardly meet stays as it is: there is nothing to refine on.
    """
    belief = pair.settings.judgement
    refined: list[Trial] = []
    for trial in trials:
        if len(refined) == pair.settings.rivals:
            break
        known = any(not _differ(pair, trial, other) for other in refined)
        if known or (refined and not _is_worth(trial.found, belief)):
            continue
        if trial.found.overlap < belief.min_overlap:
            refined.append(trial)
            continue
        ended = pair.align(trial.T)
        refined.append(Trial(trial.start, ended, pair.verify(ended.T_target_source)))
    return _keep_distinct(pair, refined)


def _is_worth(found: Verification, belief: verification.VerificationSettings) -> bool:
    """Whether a coarse pose may be one that is believed when it is aligned on all surfels."""
    return found.overlap >= _WORTH * belief.min_overlap and found.violations <= belief.max_violations / _WORTH**2


def _keep_distinct(pair: PairRegistration, trials: Sequence[Trial]) -> list[Trial]:
    """Sort the trials, best first, and drop those that do not count as another pose than a better one."""
    kept: list[Trial] = []
    for trial in sorted(trials, key=lambda trial: -trial.found.score):
        if all(_differ(pair, trial, other) for other in kept):
            kept.append(trial)
    return kept


def _differ(pair: PairRegistration, a: Trial, b: Trial) -> bool:
    return pair.distance(a.T, b.T) > 1.0


def _is_rival(pair: PairRegistration, trial: Trial, best: Trial, freedoms: Sequence[Freedom]) -> bool:
    """Whether a pose differs from the best by more than the motions that are free anyway."""
    center = (best.T @ np.append(pair.source.coarse_surfels.points.mean(axis=0), 1.0))[:3]
    T = take_out(trial.T @ np.linalg.inv(best.T), freedoms, center) @ best.T
    return pair.distance(T, best.T) > 1.0


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
