"""What makes a pair ambiguous: a motion that its views cannot determine, or another pose that explains them as well.

A bottle may turn about its axis and a plane shift along itself; a box looks the same from two sides.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.hypotheses import screen
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.registration.unobservable import Motion
from orbitscan.processing.results.estimates import Freedom
from orbitscan.recorder import poses

_APART = 1.5  # radians between two alignments whose motion tells a free axis ...
_SAME_AXIS = 0.7  # ... if that lies so near to the one looked for, as a cosine
_NO_TURN = 1e-9  # radians for a unit of a motion: below, it is a shift
_PURE = 0.15  # of the strongest turn: weaker ones in a mixture of free motions are taken for none


def find_freedoms(pair: PairRegistration, T: np.ndarray, motions: Sequence[Motion]) -> tuple[Freedom, ...]:
    """Find the motions along which the source can leave a pose T_target_source while the views agree as well.

    Each weak motion is tried out both ways, a little beyond what makes two poses distinct: it is free where the views
    agree as well there, as they are or, unless they return, when aligned again.
    """
    settings, (turn, shift) = pair.settings.symmetry, pair.distinct
    weak = [motion for motion in motions if motion.information < settings.suspicious]
    tried = weak
    steps = [motion.pose(sign * settings.probe * motion.size(turn, shift)) for motion in tried for sign in (1, -1)]
    leaves = _try_steps(pair, T, steps)
    either = {motion: leaves[2 * k] or leaves[2 * k + 1] for k, motion in enumerate(tried)}
    free = [motion.freedom(turn, shift) for motion in _separate([m for m in weak if either.get(m, True)])]
    return tuple(_sharpen(freedom, pair, T) for freedom in free)


def _try_steps(pair: PairRegistration, T: np.ndarray, steps: Sequence[np.ndarray]) -> list[bool]:
    """Tell whether the views agree as well after each step (4, 4) from T_target_source, or aligned from there."""
    if not steps:
        return []
    settings = pair.settings.symmetry
    probes = np.array([step @ T for step in steps])
    ends = pair.align_coarsely(probes, settings.probe_gate, settings.probe_deviation)
    here, limit = pair.explain(T), pair.settings.symmetry.as_well
    as_well = []
    for probe, end in zip(probes, ends, strict=True):
        returned = pair.distance(end, T) < settings.held * settings.probe
        found = (pair.explain(pose) for pose in ([probe] if returned else [probe, end]))
        as_well.append(any(there.worse_than(here) <= limit for there in found))
    return as_well


def _separate(motions: Sequence[Motion]) -> list[Motion]:
    """Mix free motions about one centre into others that span the same: pure shifts first, as far as there are any.

    Where a motion and another are free, so is every mixture, and eigenvectors are any of those.
    """
    if len(motions) < 2:
        return list(motions)
    information = max(motion.information for motion in motions)
    turns, shifts = np.array([m.turn for m in motions]), np.array([m.shift for m in motions])
    mixtures, sizes, _ = np.linalg.svd(turns)
    sizes = np.concatenate([sizes, np.zeros(len(motions))])[: len(motions)]
    mixed = []
    for size, mixture in sorted(zip(sizes, mixtures.T, strict=True), key=lambda item: item[0]):
        turn, shift = mixture @ turns, mixture @ shifts
        pure = size < _PURE * sizes.max()
        mixed.append(Motion(np.zeros(3) if pure else turn, shift, motions[0].center, information))
    return mixed


def _sharpen(freedom: Freedom, pair: PairRegistration, T: np.ndarray) -> Freedom:
    """Give a free turn the axis of the motion between two alignments that start apart along it; it is a better one.

    Alignment takes out every error of the axis but not the turn; noisy normals tell the axis of a bowl ten times worse.
    """
    if freedom.kind != "turn":
        return freedom
    starts = [poses.turn_about(freedom.axis, freedom.point, angle) @ T for angle in (_APART / 2, -_APART / 2)]
    first, second = (pair.align(start).T_target_source for start in starts)
    D = first @ poses.invert(second)
    turn = Rotation.from_matrix(D[:3, :3]).as_rotvec()
    angle = float(np.linalg.norm(turn))
    if angle < _APART / 2 or np.dot(turn, freedom.axis) < angle * _SAME_AXIS:
        return freedom
    axis = turn / angle
    point = np.linalg.lstsq(D[:3, :3] - np.eye(3), -D[:3, 3], rcond=1e-6)[0]
    return Freedom("turn", axis, point + axis * np.dot(freedom.point - point, axis))


def turn_around(pair: PairRegistration, T: np.ndarray, motions: Sequence[Motion]) -> dict[str, np.ndarray]:
    """Turn a pose about the axes of weak turns: the poses that geometry does not refute at a first look, by angle.

    The names of those about a second or third axis, a sphere's, say which. Best first.
    """
    settings = pair.settings.symmetry
    names, candidates = [], [T]
    turns = [m for m in motions if m.information < settings.suspicious and np.linalg.norm(m.turn) > _NO_TURN]
    for k, motion in enumerate(turns):
        for angle in 2 * np.pi * np.arange(1, settings.around) / settings.around:
            candidates.append(motion.pose(angle / np.linalg.norm(motion.turn)) @ T)
            names.append(f"turned by {np.degrees(angle):.0f}" + (f" about axis {k + 1}" if k else ""))
    if not names:
        return {}
    here, *scores = screen(np.array(candidates), pair.source, pair.target, pair.settings.proposals)
    ranked = sorted(range(len(names)), key=lambda i: -scores[i])
    kept = [i for i in ranked if scores[i] >= settings.around_score * here][: settings.around_most]
    return {names[i]: candidates[i + 1] for i in kept}
