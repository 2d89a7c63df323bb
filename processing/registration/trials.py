"""The trials of a competition: poses that starts lead to, sifted from many coarse ones to the few that may be right."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.registration.ambiguity.free_motions import turn_around
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.surface_icp import Refined
from orbitscan.processing.registration.unobservable import take_out
from orbitscan.processing.registration.verification import Verification, VerificationSettings
from orbitscan.processing.results.estimates import Freedom
from orbitscan.recorder import poses

_SAME_END = 0.3  # of what makes two poses distinct: starts that end so near to each other end in one place
_WORTH = 0.75  # of what is asked of a pose, of a coarse one that is aligned further
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


def put_best_explained_first(pair: PairRegistration, trials: Sequence[Trial]) -> list[Trial]:
    """Put first the best one of the trials, which come best first, that none of the others explains clearly better.

    What overlaps more is no better for it: a pose is preferred where what both sensors must see decides.
    """
    belief, limit = pair.settings.judgement, pair.settings.covisibility.worse
    likely = [trial for trial in trials if is_believed(trial.found, belief) and trial.found.score >= belief.min_score]
    if len(likely) < 2:
        return list(trials)
    explained = [pair.explain(trial.T) for trial in likely]
    first = next(
        (k for k, ours in enumerate(explained) if all(ours.worse_than(other) <= limit for other in explained)),
        min(range(len(likely)), key=lambda k: max(explained[k].worse_than(other) for other in explained)),
    )
    return [likely[first], *(trial for trial in trials if trial is not likely[first])]


def start_around(pair: PairRegistration, trials: Sequence[Trial]) -> dict[str, np.ndarray]:
    """Return more starts about the best trials that nearly slide: the right pose may be farther along the way."""
    starts: dict[str, np.ndarray] = {}
    for trial in trials[: pair.settings.rivals]:
        motions = pair.find_motions(trial.T, coarse=True)
        if pair.nearly_slides(motions) and trial.found.score >= pair.settings.judgement.min_score:
            around = turn_around(pair, trial.T, motions)
            starts |= {f"{trial.start}, {turn}": T for turn, T in around.items()}
    return starts


def turn_by_itself(
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
        if known or not meets or not is_rival(pair, trial, best, freedoms):
            continue
        ended = pair.align_judged(T)
        trials.append(Trial("itself", ended, pair.verify(ended.T_target_source)))
    return [trial for trial in trials if is_rival(pair, trial, best, freedoms)]


def try_starts(pair: PairRegistration, starts: Mapping[str, np.ndarray]) -> list[Trial]:
    """Align the coarse surfels from each start; the trials come best first, those that end together once."""
    how = pair.settings.refinement
    ends = pair.align_coarsely(np.array(list(starts.values())), how.coarse_gate, how.coarse_deviation)
    trials: list[Trial] = []
    for name, T in zip(starts, ends, strict=True):
        if all(pair.distance(T, other.T) > _SAME_END for other in trials):
            trials.append(Trial(name, Refined(T, converged=False), pair.verify(T, coarse=True)))
    return keep_distinct(pair, trials)


def settle(pair: PairRegistration, trial: Trial) -> Trial:
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


def refine(pair: PairRegistration, trials: Sequence[Trial]) -> list[Trial]:
    """Refine the trials that may be believed on the judged surfels; what is returned is distinct, best first.

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
        ended = pair.align_judged(trial.T)
        refined.append(Trial(trial.start, ended, pair.verify(ended.T_target_source)))
    return keep_distinct(pair, refined)


def finish(pair: PairRegistration, trial: Trial) -> Trial:
    """Align the winner on all surfels; one whose surfaces hardly meet stays as it is."""
    if trial.refined.center is None:
        return trial
    ended = pair.align(trial.T)
    return Trial(trial.start, ended, pair.verify(ended.T_target_source))


def _is_worth(found: Verification, belief: VerificationSettings) -> bool:
    """Whether a coarse pose may be one that is believed when it is aligned further."""
    return found.overlap >= _WORTH * belief.min_overlap and found.violations <= belief.max_violations / _WORTH**2


def keep_distinct(pair: PairRegistration, trials: Sequence[Trial]) -> list[Trial]:
    """Sort the trials, best first, and drop those that do not count as another pose than a better one."""
    kept: list[Trial] = []
    for trial in sorted(trials, key=lambda trial: -trial.found.score):
        if all(_differ(pair, trial, other) for other in kept):
            kept.append(trial)
    return kept


def _differ(pair: PairRegistration, a: Trial, b: Trial) -> bool:
    return pair.distance(a.T, b.T) > 1.0


def is_rival(pair: PairRegistration, trial: Trial, best: Trial, freedoms: Sequence[Freedom]) -> bool:
    """Whether a pose differs from the best by more than the motions that are free anyway."""
    T = take_out(trial.T @ poses.invert(best.T), freedoms, pair.center(best.T)) @ best.T
    return pair.distance(T, best.T) > 1.0


def is_believed(found: Verification, belief: VerificationSettings) -> bool:
    """Whether a pose would be believed if it were the only one, but for how well it explains what it must."""
    return found.overlap >= belief.min_overlap and found.violations <= belief.max_violations
