"""The orbit of a pair: all poses that explain what both sensors must see as well as the best one, within the noise.

A pose is right only where no other one is: a hexagonal prism turned by 60 degrees explains its views as well, however
many surfels overlap. Poses that differ by a turn about an axis tell a symmetry, of which every turn is tried.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.registration.ambiguity.symmetry import expand, is_among, is_turn, name_turn
from orbitscan.processing.registration.covisibility import Explanation
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.unobservable import take_out
from orbitscan.processing.results.estimates import Freedom, Symmetry
from orbitscan.recorder import poses

_ONE_OF_MANY = 2.0  # times what refutes a pose, for each turn of a symmetry: all of them together decide
_HOPELESS = 6.0  # times what refutes a pose: alignment will not mend it


@dataclass(frozen=True, eq=False)
class Orbit:
    """All that explains a pair as well as its best pose, and by how much the next candidate explains it worse."""

    symmetries: tuple[Symmetry, ...] = ()  # in the target's frame
    freedoms: tuple[Freedom, ...] = ()  # turns about an axis of which any angle explains the views
    alternatives: tuple[np.ndarray, ...] = ()  # other T_target_source that no symmetry leads to
    margin: float | None = None  # standard deviations; None where nothing else was a candidate

    @property
    def is_single(self) -> bool:
        """Whether the best pose is the only one."""
        return not (self.symmetries or self.freedoms or self.alternatives)


def find_orbit(
    pair: PairRegistration,
    T_best: np.ndarray,
    rivals: Sequence[np.ndarray],
    freedoms: Sequence[Freedom],
    suspected: Sequence[Symmetry] = (),
) -> Orbit:
    """Find the orbit of the best T_target_source from its rivals and suspected symmetries (target's frame).

    Rivals are aligned poses that differ from the best by more than its free motions.
    """
    here, limit = pair.explain(T_best), pair.settings.covisibility.worse
    worse = [pair.explain(T).worse_than(here) for T in rivals]
    standing = [T for T, by in zip(rivals, worse, strict=True) if by <= limit]
    refuted = [by for by in worse if by > limit]
    symmetries: list[Symmetry] = []
    free = list(freedoms)
    alternatives: list[np.ndarray] = []
    for symmetry in suspected:
        if is_turn(free, symmetry, pair.diameter) or is_among(symmetries, symmetry, pair.diameter):
            continue
        stands = [
            found for turn in symmetry.turns() if (found := _stands(pair, turn @ T_best, here, limit)) is not None
        ]
        if len(stands) == symmetry.order - 1:
            symmetries.append(symmetry)
        else:
            standing += [T for T, _ in stands if pair.verify(T).overlap >= pair.settings.judgement.min_overlap]

    def worse_by(turn: np.ndarray) -> float | None:
        found = _stands(pair, turn @ T_best, here, _ONE_OF_MANY * limit)
        return None if found is None else found[1]

    for T in standing:
        if _is_known(pair, T, T_best, symmetries, free, alternatives):
            continue
        turn = name_turn(T @ poses.invert(T_best), pair.center(T_best), pair.distinct[1], worse_by)
        if isinstance(turn, Freedom):
            free.append(turn)
        elif turn is not None:
            symmetries.append(turn)
        else:
            alternatives.append(T)
    alternatives = [T for T in alternatives if not _is_known(pair, T, T_best, symmetries, free, ())]
    new = tuple(freedom for freedom in free if freedom not in freedoms)
    return Orbit(tuple(symmetries), new, tuple(alternatives), min(refuted, default=None))


def _stands(pair: PairRegistration, T: np.ndarray, here: Explanation, limit: float) -> tuple[np.ndarray, float] | None:
    """A pose that explains the views as well, as it is or aligned from there, and by how much worse; None: refuted."""
    if (worse := pair.explain(T).worse_than(here)) <= limit:
        return T, worse
    if worse > _HOPELESS * limit:
        return None
    aligned = pair.align_judged(T).T_target_source
    if pair.distance(aligned, T) > 1.0 or (worse := pair.explain(aligned).worse_than(here)) > limit:
        return None
    return aligned, worse


def _is_known(
    pair: PairRegistration,
    T: np.ndarray,
    T_best: np.ndarray,
    symmetries: Sequence[Symmetry],
    freedoms: Sequence[Freedom],
    alternatives: Sequence[np.ndarray],
) -> bool:
    """Whether symmetries, free motions or alternatives account for a pose."""
    center = pair.center(T_best)
    for turn in expand(symmetries):
        D = take_out(T @ poses.invert(turn @ T_best), freedoms, center)
        if pair.distance(D @ turn @ T_best, turn @ T_best) <= 1.0:
            return True
    return any(pair.distance(T, other) <= 1.0 for other in alternatives)
