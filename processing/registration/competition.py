"""A competition of starts: alignment takes each to a pose, geometry judges the poses, and says what rivals the best."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from orbitscan.processing.registration import surface_icp, verification
from orbitscan.processing.registration.hypotheses import StartSettings
from orbitscan.processing.registration.matching import MatchSettings
from orbitscan.processing.registration.prepared_view import Prepared
from orbitscan.processing.registration.surface_icp import Refined, RefinementSettings
from orbitscan.processing.registration.symmetry import (
    Motion,
    SymmetrySettings,
    find_freedoms,
    turned_around,
    weak_motions,
)
from orbitscan.processing.registration.unobservable import hold, take_out, turn_by_step
from orbitscan.processing.registration.verification import Judgement, JudgementSettings
from orbitscan.processing.results.records import Candidate, Evidence, Freedom, PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.processing.surface.preparation import Surfels

_SAME_END = 0.3  # of what makes two poses distinct: starts that end so near to each other end in one place
_SETTLING = (1.6, 0.8, 0.8, 0.4, 0.2)  # steps along a weak motion, in what makes two poses distinct
_STEP_DEVIATION_DEG = 0.2  # of a turntable's step that the user knows
_STEP_MISFIT = 1.5  # times that of the pose without that knowledge: what fits worse contradicts the user


@dataclass(frozen=True)
class PairSettings:
    """How starts compete, how a pose is refined, and when it is believed."""

    starts: tuple[Literal["identity", "previous", "consensus"], ...] = ("identity", "previous", "consensus")
    # What competes: no motion, the previous step of the camera, and all that the correspondences propose.
    step_deg: float | None = None  # from one recorded view to the next, where the user knows it; see `turn_by_step`
    rivals: int = 3  # poses refined on all surfels, at most
    proposals: StartSettings = field(default_factory=StartSettings)
    # Where these lead nowhere, the correspondences are looked at once more:
    thorough: StartSettings = field(default_factory=lambda: StartSettings(hypotheses=3000, worth=0.0, most=16))
    thorough_matching: MatchSettings = field(default_factory=lambda: MatchSettings(nearest=2))
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    judgement: JudgementSettings = field(default_factory=JudgementSettings)
    symmetry: SymmetrySettings = field(default_factory=SymmetrySettings)


@dataclass(frozen=True, eq=False)
class Trial:
    """A pose that competes: where it started, where it ended, and how far the views agree there."""

    start: str  # its name, see `Candidate`
    refined: Refined
    judged: Judgement

    @property
    def T(self) -> np.ndarray:
        """T_target_source."""
        return self.refined.T_target_source


def register_from(
    starts: Mapping[str, np.ndarray],
    source: Prepared,
    target: Prepared,
    settings: PairSettings,
    features: Mapping[str, float | int] | None = None,
) -> PairEstimate:
    """The best pose that any of the named starts T_target_source (at least one) leads to, and what rivals it.

    `features` is the evidence of the correspondences, where there are any. The information and freedoms are of the best
    pose; alternatives are rivals that explain the views as well.
    """
    belief = settings.judgement
    trials = _try(starts, source, target, settings)
    if around := _around(trials, source, target, settings):
        trials = _distinct([*trials, *_try(around, source, target, settings)], source, belief)
        settled = [_settled(trial, source, target, settings) for trial in trials[: settings.rivals]]
        trials = _distinct([*settled, *trials[settings.rivals :]], source, belief)
    best, *others = _refine(trials, source, target, settings)
    motions, nearly_slides = _weak_motions(best, source.many, target, settings)
    freedoms: tuple[Freedom, ...] = ()
    if nearly_slides and best.judged.score >= belief.min_score:
        freedoms = find_freedoms(best.T, motions, source, target, settings.refinement, belief, settings.symmetry)
    rivals = [trial for trial in others if _is_rival(trial, best, freedoms, source, belief)]
    equal = [trial for trial in rivals if verification.as_good(trial.judged, best.judged, belief)]
    if freedoms and settings.step_deg is not None:
        best, freedoms = _use_step(best, freedoms, source, target, settings)
    status = verification.status_of(best.judged, belief, nearly_slides)
    if status == Status.OK and not motions:
        status = Status.LOW_OVERLAP
    if status == Status.OK and (freedoms or equal):
        status = Status.AMBIGUOUS
    return PairEstimate(
        source.view,
        target.view,
        best.T,
        status,
        verification.confidence(best.judged, max((trial.judged.score for trial in rivals), default=0.0)),
        evidence_of(source, best.refined, best.judged, motions, features or {}),
        tuple(
            Candidate(trial.start, verification.status_of(trial.judged, belief), trial.judged.score) for trial in trials
        ),
        start=best.start,
        information=best.refined.information,
        center=best.refined.center,
        freedoms=freedoms,
        alternatives=tuple(trial.T for trial in equal),
    )


def _weak_motions(
    trial: Trial, surfels: Surfels, target: Prepared, settings: PairSettings
) -> tuple[list[Motion], bool]:
    """The motions of a pair, the least determined first, and whether that one is hardly determined.

    None where fewer than six surfels have partners (see `weak_motions`).
    """
    motions = weak_motions(trial.T, surfels, target, settings.judgement.gate * target.scale.working)
    return motions, bool(motions) and motions[0].information < settings.symmetry.suspicious


def _around(
    trials: Sequence[Trial], source: Prepared, target: Prepared, settings: PairSettings
) -> dict[str, np.ndarray]:
    """More starts where the best trials nearly slide: the right pose may be farther along the way."""
    starts: dict[str, np.ndarray] = {}
    for trial in trials[: settings.rivals]:
        motions, nearly_slides = _weak_motions(trial, source.few, target, settings)
        if nearly_slides and trial.judged.score >= settings.judgement.min_score:
            around = turned_around(trial.T, motions, source, target, settings.proposals, settings.symmetry)
            starts |= {f"{trial.start}, {turn}": T for turn, T in around.items()}
    return starts


def _use_step(
    best: Trial, freedoms: tuple[Freedom, ...], source: Prepared, target: Prepared, settings: PairSettings
) -> tuple[Trial, tuple[Freedom, ...]]:
    """A pose turned along its free turn to where the user knows it to be, if the views agree; what is still free."""
    turn = next((freedom for freedom in freedoms if freedom.kind == "turn"), None)
    if turn is None or best.refined.information is None:
        return best, freedoms
    T = turn_by_step(best.T, turn, settings.step_deg * (source.view - target.view))
    judged = verification.judge(T, source, target, settings.judgement)
    close = judged.misfit <= _STEP_MISFIT * best.judged.misfit
    if not close or verification.status_of(judged, settings.judgement, nearly_slides=True) != Status.OK:
        return best, freedoms
    known = hold(best.refined.information, best.refined.center, turn, np.radians(_STEP_DEVIATION_DEG))
    refined = replace(best.refined, T_target_source=T, information=known)
    return Trial("step", refined, judged), tuple(freedom for freedom in freedoms if freedom is not turn)


def _try(starts: Mapping[str, np.ndarray], source: Prepared, target: Prepared, settings: PairSettings) -> list[Trial]:
    """Where a few surfels take each start, best first; those that end together once."""
    w, how = source.scale.working, settings.refinement
    ends = surface_icp.align_coarsely(
        source.few, target.coarse, np.array(list(starts.values())), how.coarse_gate * w, how.coarse_deviation * w,
        how.coarse_iterations, how.coarse_still * source.scale.diameter,
    )  # fmt: skip
    trials: list[Trial] = []
    for name, T in zip(starts, ends, strict=True):
        if all(verification.distance(T, other.T, source, settings.judgement) > _SAME_END for other in trials):
            judged = verification.judge(T, source, target, settings.judgement, few=True)
            trials.append(Trial(name, Refined(T, converged=False), judged))
    return _distinct(trials, source, settings.judgement)


def _settled(trial: Trial, source: Prepared, target: Prepared, settings: PairSettings) -> Trial:
    """A trial that nearly slides, moved along its weakest motion to where the views agree best: alignment does not."""
    motions, nearly_slides = _weak_motions(trial, source.few, target, settings)
    if not nearly_slides:
        return trial
    belief = settings.judgement
    unit = motions[0].size(np.radians(belief.distinct_deg), belief.distinct_shift * source.scale.diameter)
    for size in _SETTLING:
        for sign in (1, -1):
            T = motions[0].pose(sign * size * unit) @ trial.T
            judged = verification.judge(T, source, target, belief, few=True)
            if judged.score > trial.judged.score:
                trial = Trial(trial.start, Refined(T, converged=False), judged)
                break
    return trial


def _refine(trials: Sequence[Trial], source: Prepared, target: Prepared, settings: PairSettings) -> list[Trial]:
    """The trials that come near the best one, refined on all surfels; best first, distinct.

    One whose surfaces hardly meet stays as it is: there is nothing to refine on.
    """
    scale, belief = source.scale, settings.judgement
    refined: list[Trial] = []
    least = belief.rival_score * trials[0].judged.score
    for trial in trials[: settings.rivals]:
        known = any(not _apart(trial, other, source, belief) for other in refined)
        if known or (refined and trial.judged.score < least):
            continue
        if trial.judged.score < belief.min_score:
            refined.append(trial)
            continue
        ended = surface_icp.align(
            source.surface.surfels, source.few, target.fine, trial.T, scale.working, scale.diameter, settings.refinement
        )
        judged = verification.judge(ended.T_target_source, source, target, belief)
        refined.append(Trial(trial.start, ended, judged))
    return _distinct(refined, source, belief)


def _distinct(trials: Sequence[Trial], source: Prepared, settings: JudgementSettings) -> list[Trial]:
    """The trials, best first, without those that do not count as another pose than a better one."""
    kept: list[Trial] = []
    for trial in sorted(trials, key=lambda trial: -trial.judged.score):
        if all(_apart(trial, other, source, settings) for other in kept):
            kept.append(trial)
    return kept


def _apart(a: Trial, b: Trial, source: Prepared, settings: JudgementSettings) -> bool:
    return verification.distance(a.T, b.T, source, settings) > 1.0


def _is_rival(
    trial: Trial, best: Trial, freedoms: Sequence[Freedom], source: Prepared, settings: JudgementSettings
) -> bool:
    """Whether a pose differs from the best by more than the motions that are free anyway."""
    center = (best.T @ np.append(source.few.points.mean(axis=0), 1.0))[:3]
    T = take_out(trial.T @ np.linalg.inv(best.T), freedoms, center) @ best.T
    return verification.distance(T, best.T, source, settings) > 1.0


def doubt(pair: PairEstimate, usual_misfit: float | None, settings: PairSettings) -> PairEstimate:
    """A pair that nearly slides is not believed where it fits clearly less closely than others of its session do.

    A mug upside down agrees with itself up to its handle and rim: no surface contradicts it, it just fits worse.
    """
    slides = pair.evidence.observability is not None and pair.evidence.observability < settings.symmetry.suspicious
    if pair.status != Status.OK or usual_misfit is None or not slides:
        return pair
    worse = pair.evidence.misfit > settings.judgement.sliding_misfit * usual_misfit
    return replace(pair, status=Status.DIVERGED) if worse else pair


def evidence_of(
    source: Prepared,
    refined: Refined,
    judged: Judgement,
    motions: Sequence[Motion],
    features: Mapping[str, float | int],
) -> Evidence:
    """What speaks for a pose; `motions` are the pair's, the least determined first."""
    met = judged.overlap > 0
    return Evidence(
        points=len(source.surface.working),
        converged=refined.converged,
        rmse_m=judged.rmse if met else None,
        overlap=judged.overlap,
        misfit=judged.misfit if met else None,
        violations=judged.violations if met else None,
        unseen=judged.unseen if met else None,
        observability=motions[0].information if motions else None,
        **features,
    )
