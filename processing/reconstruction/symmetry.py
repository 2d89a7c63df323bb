"""Motions that two views cannot determine: a bottle's turn about its axis, a plane's shift along itself."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from processing.reconstruction import judgement, refinement
from processing.reconstruction.judgement import JudgementSettings
from processing.reconstruction.prepared import Prepared
from processing.reconstruction.refinement import RefinementSettings
from processing.reconstruction.starts import StartSettings, screen
from processing.results.records import Freedom
from processing.surface import Surfels
from recorder import poses

_APART = 1.5  # radians between two alignments whose motion tells a free axis ...
_SAME_AXIS = 0.7  # ... if it lies so near to the one looked for, as a cosine
_PURE = 0.15  # of the strongest turn: weaker ones in a mixture of free motions are taken for none
_ROUNDS = 5  # of taking out one free motion after the other, where there are several


@dataclass(frozen=True)
class SymmetrySettings:
    """When a motion is taken for free; not in the thesis."""

    free: float = 0.0015  # information about a motion, 0 to 1, below which it is free: what is left is noise of normals
    suspicious: float = 0.02  # below which it is tried out
    probe: float = 1.3  # how far it is tried, as a multiple of what makes two poses distinct
    probe_gate: float = 3.0  # multiples of w, of the alignment from there ...
    probe_deviation: float = 0.5  # ... in which residuals of this many w count half
    held: float = 0.5  # a motion that the alignment takes back by more than this share is determined
    around: int = 24  # poses looked at about the axis of a suspicious turn: the right one may be any of them
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
    averages out, where the square of one view's would be taken for relief. None where the views do not meet.
    """
    points = poses.transform(T, surfels.points)
    normals = poses.transform(poses.make(T[:3, :3], np.zeros(3)), surfels.normals)
    partner = refinement.find_partners(points, normals, target.fine, gate)
    near = partner >= 0
    if near.sum() < 6:
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
    w, diameter = source.scale.working, source.scale.diameter
    turn, shift = np.radians(belief.distinct_deg), belief.distinct_shift * diameter
    weak = [motion for motion in motions if motion.information < settings.suspicious]
    tried = [motion for motion in weak if motion.information >= settings.free]
    found = {id(motion) for motion in weak} - {id(motion) for motion in tried}
    if tried:
        sizes = [settings.probe * motion.size(turn, shift) for motion in tried]
        probes = [m.pose(sign * size) @ T for m, size in zip(tried, sizes, strict=True) for sign in (1, -1)]
        ends = refinement.align_coarsely(
            source.few, target.coarse, np.array(probes), settings.probe_gate * w, settings.probe_deviation * w,
            how.coarse_iterations, how.coarse_still * diameter,
        )  # fmt: skip
        here = judgement.judge(T, source, target, belief)
        for motion, pose, end in zip([m for m in tried for _ in (1, -1)], probes, ends, strict=True):
            returned = judgement.distance(end, T, source, belief) < settings.held * settings.probe
            if any(
                judgement.as_good(judgement.judge(other, source, target, belief), here, belief)
                for other in ([pose] if returned else [pose, end])
            ):
                found.add(id(motion))
    free = [motion.freedom(turn, shift) for motion in _separated([m for m in weak if id(m) in found])]
    return tuple(_sharpened(freedom, T, source, target, how) for freedom in free)


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
            refinement.align(
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
    """Poses about the axes of weak turns that geometry does not refute at a first look, named by their angle."""
    angles = 2 * np.pi * np.arange(1, settings.around) / settings.around
    poses_around = {}
    for motion in motions:
        if motion.information < settings.suspicious and np.linalg.norm(motion.turn) > 1e-9:
            for angle in angles:
                poses_around[f"turned by {np.degrees(angle):.0f}"] = (
                    motion.pose(angle / np.linalg.norm(motion.turn)) @ T
                )
    if not poses_around:
        return {}
    names, candidates = list(poses_around), np.array([T, *poses_around.values()])
    here, *scores = screen(candidates, source, target, proposals)
    ranked = sorted(zip(scores, range(len(names)), strict=True), key=lambda item: (-item[0], item[1]))
    kept = [i for value, i in ranked if value >= settings.around_score * here][: settings.around_most]
    return {names[i]: poses_around[names[i]] for i in kept}


def direction(freedom: Freedom, center: np.ndarray) -> np.ndarray:
    """A unit of a free motion (6,): a turn about the centre (3,), then a shift."""
    if freedom.kind == "turn":
        return np.concatenate([freedom.axis, np.cross(freedom.axis, center - freedom.point)])
    return np.concatenate([np.zeros(3), freedom.axis])


def release(A: np.ndarray, center: np.ndarray, freedom: Freedom) -> np.ndarray:
    """Information A (6, 6) that says nothing along a free motion, and as much as before of all others."""
    v = A @ direction(freedom, center)
    return A - np.outer(v, v) / max(float(direction(freedom, center) @ v), 1e-300)


def hold(A: np.ndarray, center: np.ndarray, freedom: Freedom, deviation: float) -> np.ndarray:
    """Information A (6, 6) with a motion known to a standard deviation [rad, m] that the views leave free."""
    v = direction(freedom, center)
    return release(A, center, freedom) + np.outer(v, v) / (v @ v * deviation) ** 2


def same_freedom(a: Freedom, b: Freedom, degrees: float = 10.0, apart: float = 0.02) -> bool:
    """Whether two free motions in one frame are one: axes within so many degrees, lines within so many metres."""
    along = abs(float(np.dot(a.axis, b.axis)))
    between = np.cross(b.point - a.point, a.axis)
    near = a.kind == "shift" or float(np.linalg.norm(between)) < apart
    return a.kind == b.kind and along > np.cos(np.radians(degrees)) and near


def take_out(D: np.ndarray, freedoms: Sequence[Freedom], center: np.ndarray) -> np.ndarray:
    """A motion D (4, 4) of an object with this centre (3,), less its part along the free motions."""
    for _ in range(_ROUNDS if len(freedoms) > 1 else 1):
        for freedom in freedoms:
            if freedom.kind == "turn":
                R = Rotation.from_rotvec(-poses.twist(D[:3, :3], freedom.axis) * freedom.axis).as_matrix()
                D = poses.make(R, freedom.point - R @ freedom.point) @ D
            else:
                moved = poses.transform(D, center[None])[0] - center
                D = poses.make(np.eye(3), -np.dot(moved, freedom.axis) * freedom.axis) @ D
    return D
