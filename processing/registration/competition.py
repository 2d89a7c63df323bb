"""A competition of starts: alignment takes each to a pose, geometry verifies the poses and tells the best's rivals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orbitscan.processing.registration import verification
from orbitscan.processing.registration.ambiguity import as_good, decide, find_freedoms, turn_around
from orbitscan.processing.registration.hypotheses import propose
from orbitscan.processing.registration.matching import match
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.registration.surface_icp import Refined
from orbitscan.processing.registration.unobservable import hold, take_out, turn_by_step
from orbitscan.processing.registration.verification import Verification
from orbitscan.processing.results.estimates import Candidate, Evidence, Freedom, PairEstimate
from orbitscan.processing.results.status import Status

_SAME_END = 0.3  # of what makes two poses distinct: starts that end so near to each other end in one place
_SETTLING = (1.6, 0.8, 0.8, 0.4, 0.2)  # steps along a weak motion, in what makes two poses distinct
_STEP_DEVIATION_DEG = 0.2  # of a turntable's step that the user knows
_STEP_MISFIT = 1.5  # times that of the pose without that knowledge: what fits worse contradicts the user


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
    if best.status.is_believed:
        return best
    more = match(source.descriptors, target.descriptors, settings.thorough_matching)
    again = _compete(pair, _name(propose(source, target, more, settings.thorough)), matches)
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
    best, *others = _refine(pair, trials)
    motions = pair.find_motions(best.T)
    slides = pair.nearly_slides(motions)
    freedoms: tuple[Freedom, ...] = ()
    if slides and best.found.score >= belief.min_score:
        freedoms = find_freedoms(pair, best.T, motions)
    rivals = [trial for trial in others if _is_rival(pair, trial, best, freedoms)]
    equal = [trial for trial in rivals if as_good(trial.found, best.found, belief)]
    if freedoms and pair.settings.step_deg is not None:
        best, freedoms = _use_step(pair, best, freedoms, pair.settings.step_deg)
    status = verification.status_of(best.found, belief, slides)
    if status == Status.OK and not motions:
        status = Status.LOW_OVERLAP
    return PairEstimate(
        pair.source.view,
        pair.target.view,
        best.T,
        decide(status, freedoms, equal),
        verification.confidence(best.found, max((trial.found.score for trial in rivals), default=0.0)),
        pair.gather_evidence(best.refined, best.found, motions, features),
        tuple(
            Candidate(trial.start, verification.status_of(trial.found, belief), trial.found.score) for trial in trials
        ),
        start=best.start,
        information=best.refined.information,
        center=best.refined.center,
        freedoms=freedoms,
        alternatives=tuple(trial.T for trial in equal),
    )


def _turn_around(pair: PairRegistration, trials: Sequence[Trial]) -> dict[str, np.ndarray]:
    """Return more starts about the best trials that nearly slide: the right pose may be farther along the way."""
    starts: dict[str, np.ndarray] = {}
    for trial in trials[: pair.settings.rivals]:
        motions = pair.find_motions(trial.T, coarse=True)
        if pair.nearly_slides(motions) and trial.found.score >= pair.settings.judgement.min_score:
            around = turn_around(pair, trial.T, motions)
            starts |= {f"{trial.start}, {turn}": T for turn, T in around.items()}
    return starts


def _use_step(
    pair: PairRegistration, best: Trial, freedoms: tuple[Freedom, ...], step_deg: float
) -> tuple[Trial, tuple[Freedom, ...]]:
    """Turn the best pose along its free turn to where the user's step puts it, if the views agree there.

    Returns the trial and the freedoms that are left."""
    turn = next((freedom for freedom in freedoms if freedom.kind == "turn"), None)
    if turn is None or best.refined.information is None or best.refined.center is None:
        return best, freedoms
    T = turn_by_step(best.T, turn, step_deg * (pair.source.view - pair.target.view))
    found = pair.verify(T)
    close = found.misfit <= _STEP_MISFIT * best.found.misfit
    if not close or verification.status_of(found, pair.settings.judgement, nearly_slides=True) != Status.OK:
        return best, freedoms
    known = hold(best.refined.information, best.refined.center, turn, np.radians(_STEP_DEVIATION_DEG))
    refined = replace(best.refined, T_target_source=T, information=known)
    return Trial("step", refined, found), tuple(freedom for freedom in freedoms if freedom is not turn)


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
    min_score = belief.rival_score * trials[0].found.score
    for trial in trials[: pair.settings.rivals]:
        known = any(not _differ(pair, trial, other) for other in refined)
        if known or (refined and trial.found.score < min_score):
            continue
        if trial.found.score < belief.min_score:
            refined.append(trial)
            continue
        ended = pair.align(trial.T)
        refined.append(Trial(trial.start, ended, pair.verify(ended.T_target_source)))
    return _keep_distinct(pair, refined)


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


def verify_sliding(pair: PairEstimate, usual_misfit: float | None, settings: PairSettings) -> PairEstimate:
    """Return the pair, as `diverged` if it nearly slides and fits clearly less closely than its session's others do.

    A mug upside down agrees with itself up to its handle and rim: no surface contradicts it, it just fits worse.
    """
    observability, misfit = pair.evidence.observability, pair.evidence.misfit
    slides = observability is not None and observability < settings.symmetry.suspicious
    if pair.status != Status.OK or usual_misfit is None or misfit is None or not slides:
        return pair
    worse = misfit > settings.judgement.sliding_misfit * usual_misfit
    return replace(pair, status=Status.DIVERGED) if worse else pair
