"""Motions that two views cannot determine: a bottle's turn about its axis, a plane's shift along itself."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration import surface_icp, verification
from orbitscan.processing.registration.correspondences import find_partners
from orbitscan.processing.registration.hypotheses import StartSettings, screen
from orbitscan.processing.registration.prepared_view import Prepared
from orbitscan.processing.registration.surface_icp import RefinementSettings
from orbitscan.processing.registration.verification import JudgementSettings
from orbitscan.processing.results.records import Freedom
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

_APART = 1.5  # radians between two alignments whose motion tells a free axis ...
_SAME_AXIS = 0.7  # ... if that lies so near to the one looked for, as a cosine
_MIN_PARTNERS = 6  # surfels that determine six motions
_NO_TURN = 1e-9  # radians for a unit of a motion: below, it is a shift
_PURE = 0.15  # of the strongest turn: weaker ones in a mixture of free motions are taken for none


@dataclass(frozen=True)
class SymmetrySettings:
    """When a motion is taken for free; not in the thesis."""

    # By the information about a motion, 0 to 1 (see `Motion`).
    free: float = 0.0015  # below, it is free: what is left is noise of normals
    suspicious: float = 0.02  # below, it is tried out: the views nearly slide

    # The trial: a little along the motion, and aligned again from there.
    probe: float = 1.3  # how far it is tried, as a multiple of what makes two poses distinct
    probe_gate: float = 3.0  # of the alignment from there, in multiples of the working resolution w
    probe_deviation: float = 0.5  # a residual of so many w counts a quarter there
    held: float = 0.5  # a motion of which the alignment takes back all but this share is determined

    # Poses about the axis of a suspicious turn: the right one may be any of them.
    around: int = 24  # looked at in a whole turn
    around_score: float = 0.7  # those are tried that fit this share as well at a first look ...
    around_most: int = 8  # ... but no more than so many


@dataclass(frozen=True, eq=False)
class Motion:
    """A small motion about a centre, and how much the overlap of two views says about it."""

    turn: np.ndarray  # (3,) radians for a unit of it
    shift: np.ndarray  # (3,) metres
    center: np.ndarray  # (3,) of the overlap, in the target's frame
    information: float  # mean square distance that a unit moves the surface along its normals, 0 to 1

    def size(self, turn: float, shift: float) -> float:
        """How many units turn by so many radians or shift by so many metres, whichever comes first."""
        turned, shifted = np.linalg.norm(self.turn), np.linalg.norm(self.shift)
        return float(min(turn / max(turned, 1e-12), shift / max(shifted, 1e-12)))

    def pose(self, size: float) -> np.ndarray:
        """The rigid motion (4, 4) of so many units, in the target's frame."""
        v = self.turn * size
        angle = float(np.linalg.norm(v))
        K = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
        b, c = ((1 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3) if angle > 1e-9 else (0.5, 1 / 6)
        R = Rotation.from_rotvec(v).as_matrix()
        return poses.make(R, (np.eye(3) + b * K + c * K @ K) @ self.shift * size + self.center - R @ self.center)

    def freedom(self, turn: float, shift: float) -> Freedom:
        """The motion as what nobody can determine: a turn about an axis, or a shift where that comes first."""
        turned, shifted = float(np.linalg.norm(self.turn)), float(np.linalg.norm(self.shift))
        if turned / turn >= shifted / shift:
            point = self.center + np.cross(self.turn, self.shift) / turned**2
            return Freedom("turn", self.turn / turned, point)
        return Freedom("shift", self.shift / shifted, self.center)


def weak_motions(T: np.ndarray, surfels: Surfels, target: Prepared, gate: float) -> list[Motion]:
    """The six independent motions of a source's surfels under a pose T_target_source, the least determined first.

    Eigenvectors of the mean point-to-plane information of the overlap; turns are in units of the overlap's reach, so
    that all six compare. The normals of one view are paired with those of the other: their noise is independent and
    averages out, where the square of one view's would be taken for relief. The gate [m] is how far a partner may be.
    Empty where fewer than six surfels have one.
    """
    points = poses.transform(T, surfels.points)
    normals = poses.rotate(T, surfels.normals)
    partner = find_partners(points, normals, target.fine, gate)
    near = partner >= 0
    if near.sum() < _MIN_PARTNERS:
        return []
    points, normals, others = points[near], normals[near], target.fine.normals[partner[near]]
    center = points.mean(axis=0)
    arms = points - center
    reach = max(float(np.sqrt((arms**2).sum(axis=1).mean())), 1e-12)
    one = np.hstack([np.cross(arms / reach, normals), normals])
    other = np.hstack([np.cross(arms / reach, others), others])
    M = np.einsum("ni,nj->ij", one, other) / len(points)
    information, vectors = np.linalg.eigh((M + M.T) / 2)
    return [Motion(v[:3] / reach, v[3:], center, float(i)) for i, v in zip(information, vectors.T, strict=True)]


def find_freedoms(
    T: np.ndarray,
    motions: Sequence[Motion],
    source: Prepared,
    target: Prepared,
    how: RefinementSettings,
    belief: JudgementSettings,
    settings: SymmetrySettings,
) -> tuple[Freedom, ...]:
    """The motions along which the source can leave a pose T_target_source while the views agree as well.

    Each weak motion is tried out both ways, a little beyond what makes two poses distinct: it is free where the views
    agree as well there, as they are or, unless they return, when aligned again.
    """
    turn, shift = np.radians(belief.distinct_deg), belief.distinct_shift * source.scale.diameter
    weak = [motion for motion in motions if motion.information < settings.suspicious]
    tried = [motion for motion in weak if motion.information >= settings.free]
    steps = [motion.pose(sign * settings.probe * motion.size(turn, shift)) for motion in tried for sign in (1, -1)]
    leaves = _leave_as_well(T, steps, source, target, how, belief, settings)
    either = {motion: leaves[2 * k] or leaves[2 * k + 1] for k, motion in enumerate(tried)}
    free = [motion.freedom(turn, shift) for motion in _separated([m for m in weak if either.get(m, True)])]
    return tuple(_sharpened(freedom, T, source, target, how) for freedom in free)


def _leave_as_well(
    T: np.ndarray,
    steps: Sequence[np.ndarray],
    source: Prepared,
    target: Prepared,
    how: RefinementSettings,
    belief: JudgementSettings,
    settings: SymmetrySettings,
) -> list[bool]:
    """Of each step (4, 4) from a pose T_target_source: whether the views agree as well there, or aligned from there."""
    if not steps:
        return []
    w, diameter = source.scale.working, source.scale.diameter
    probes = np.array([step @ T for step in steps])
    ends = surface_icp.align_coarsely(
        source.few, target.coarse, probes, settings.probe_gate * w, settings.probe_deviation * w,
        how.coarse_iterations, how.coarse_still * diameter,
    )  # fmt: skip
    here = verification.judge(T, source, target, belief)
    as_well = []
    for probe, end in zip(probes, ends, strict=True):
        returned = verification.distance(end, T, source, belief) < settings.held * settings.probe
        judged = (verification.judge(pose, source, target, belief) for pose in ([probe] if returned else [probe, end]))
        as_well.append(any(verification.as_good(there, here, belief) for there in judged))
    return as_well


def _separated(motions: Sequence[Motion]) -> list[Motion]:
    """Motions that span the same as some free ones about one centre: pure shifts first, as far as there are any.

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


def _sharpened(freedom: Freedom, T: np.ndarray, source: Prepared, target: Prepared, how: RefinementSettings) -> Freedom:
    """A free turn about a better axis: that of the motion between two alignments which the turn lies between.

    Alignment takes out every error of the axis but not the turn; noisy normals tell the axis of a bowl ten times worse.
    """
    if freedom.kind != "turn":
        return freedom
    ends = []
    for angle in (_APART / 2, -_APART / 2):
        R = Rotation.from_rotvec(angle * freedom.axis).as_matrix()
        start = poses.make(R, freedom.point - R @ freedom.point) @ T
        ends.append(
            surface_icp.align(
                source.surface.surfels, source.few, target.fine, start, source.scale.working, source.scale.diameter, how
            )
        )
    D = ends[0].T_target_source @ poses.invert(ends[1].T_target_source)
    turn = Rotation.from_matrix(D[:3, :3]).as_rotvec()
    angle = float(np.linalg.norm(turn))
    if angle < _APART / 2 or np.dot(turn, freedom.axis) < angle * _SAME_AXIS:
        return freedom
    axis = turn / angle
    point = np.linalg.lstsq(D[:3, :3] - np.eye(3), -D[:3, 3], rcond=1e-6)[0]
    return Freedom("turn", axis, point + axis * np.dot(freedom.point - point, axis))


def turned_around(
    T: np.ndarray,
    motions: Sequence[Motion],
    source: Prepared,
    target: Prepared,
    proposals: StartSettings,
    settings: SymmetrySettings,
) -> dict[str, np.ndarray]:
    """Poses about the axes of weak turns that geometry does not refute at a first look, named by their angle.

    Those about a second or third axis, a sphere's, say which. Best first.
    """
    names, candidates = [], [T]
    turns = [m for m in motions if m.information < settings.suspicious and np.linalg.norm(m.turn) > _NO_TURN]
    for k, motion in enumerate(turns):
        for angle in 2 * np.pi * np.arange(1, settings.around) / settings.around:
            candidates.append(motion.pose(angle / np.linalg.norm(motion.turn)) @ T)
            names.append(f"turned by {np.degrees(angle):.0f}" + (f" about axis {k + 1}" if k else ""))
    if not names:
        return {}
    here, *scores = screen(np.array(candidates), source, target, proposals)
    ranked = sorted(range(len(names)), key=lambda i: -scores[i])
    kept = [i for i in ranked if scores[i] >= settings.around_score * here][: settings.around_most]
    return {names[i]: candidates[i + 1] for i in kept}
