"""The small motions of a pair, how firmly its overlap holds each, and what follows from one that nothing holds."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.correspondences import Target, find_correspondences
from orbitscan.processing.results.estimates import Freedom
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

_MIN_SURFELS = 6  # that determine six motions
_FINENESS_DEG = 0.02  # of the turns looked at for a known step
_ROUNDS = 5  # of taking out one free motion after the other, where there are several


@dataclass(frozen=True)
class SymmetrySettings:
    """When a motion is taken for free; not in the thesis."""

    # By the information about a motion, 0 to 1 (see `Motion`).
    free: float = 0.0015  # below, the thesis's methods leave it open: what is left is noise of normals
    suspicious: float = 0.02  # below, it is tried out: the views nearly slide

    # The trial: a little along the motion, and aligned again from there.
    probe: float = 1.3  # how far it is tried, as a multiple of what makes two poses distinct
    probe_gate: float = 3.0  # of the alignment from there, in multiples of the working resolution w
    probe_deviation: float = 0.5  # a residual of so many w counts a quarter there
    as_well: float = 3.0  # standard deviations: what explains the views worse by less explains them as well
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
        """The number of units that turn by `turn` [rad] or shift by `shift` [m], whichever comes first."""
        turned, shifted = float(np.linalg.norm(self.turn)), float(np.linalg.norm(self.shift))
        return float(min(turn / max(turned, 1e-12), shift / max(shifted, 1e-12)))

    def pose(self, size: float) -> np.ndarray:
        """The rigid motion (4, 4), in the target's frame, of a number of units."""
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


def find_motions(T: np.ndarray, surfels: Surfels, target: Target, gate: float) -> list[Motion]:
    """Find the six independent motions of a source's surfels under a pose T_target_source, the least determined first.

    Eigenvectors of the mean point-to-plane information of the overlap; turns are in units of the overlap's reach, so
    that all six compare. The normals of one view are paired with those of the other: their noise is independent and
    averages out, where the square of one view's would be taken for relief. A corresponding surfel is no farther than
    the gate [m]. Empty where fewer than six surfels have one.
    """
    points = poses.transform(T, surfels.points)
    normals = poses.rotate(T, surfels.normals)
    found = find_correspondences(points, normals, target, gate)
    near = found >= 0
    if near.sum() < _MIN_SURFELS:
        return []
    points, normals, others = points[near], normals[near], target.normals[found[near]]
    center = points.mean(axis=0)
    arms = points - center
    reach = max(float(np.sqrt((arms**2).sum(axis=1).mean())), 1e-12)
    one = np.hstack([np.cross(arms / reach, normals), normals])
    other = np.hstack([np.cross(arms / reach, others), others])
    M = np.einsum("ni,nj->ij", one, other) / len(points)
    information, vectors = np.linalg.eigh((M + M.T) / 2)
    return [Motion(v[:3] / reach, v[3:], center, float(i)) for i, v in zip(information, vectors.T, strict=True)]


def direction(freedom: Freedom, center: np.ndarray) -> np.ndarray:
    """The direction (6,) of a free motion: a unit's turn [rad] about the centre (3,), then its shift [m]."""
    if freedom.kind == "turn":
        return np.concatenate([freedom.axis, np.cross(freedom.axis, center - freedom.point)])
    return np.concatenate([np.zeros(3), freedom.axis])


def release(A: np.ndarray, center: np.ndarray, freedom: Freedom) -> np.ndarray:
    """Take what it says of a free motion out of information A (6, 6) about a centre (3,); the rest stays as it is."""
    v = A @ direction(freedom, center)
    return A - np.outer(v, v) / max(float(direction(freedom, center) @ v), 1e-300)


def hold(A: np.ndarray, center: np.ndarray, freedom: Freedom, deviation: float) -> np.ndarray:
    """Set what information A (6, 6) about a centre (3,) says of a free motion to a standard deviation [rad] or [m]."""
    v = direction(freedom, center)
    return release(A, center, freedom) + np.outer(v, v) / (v @ v * deviation) ** 2


def same_freedom(a: Freedom, b: Freedom, degrees: float, apart: float) -> bool:
    """Whether two free motions in one frame are one: axes within so many degrees, lines of turns within `apart` [m]."""
    along = abs(float(np.dot(a.axis, b.axis)))
    between = np.cross(b.point - a.point, a.axis)
    near = a.kind == "shift" or float(np.linalg.norm(between)) < apart
    return a.kind == b.kind and along > np.cos(np.radians(degrees)) and near


def take_out(D: np.ndarray, freedoms: Sequence[Freedom], center: np.ndarray) -> np.ndarray:
    """Take the part along free motions out of a motion D (4, 4) of an object with a centre (3,); all in one frame."""
    for _ in range(_ROUNDS if len(freedoms) > 1 else 1):
        for freedom in freedoms:
            if freedom.kind == "turn":
                D = poses.turn_about(freedom.axis, freedom.point, -poses.twist(D[:3, :3], freedom.axis)) @ D
            else:
                moved = poses.transform(D, center[None])[0] - center
                D = poses.make(np.eye(3), -np.dot(moved, freedom.axis) * freedom.axis) @ D
    return D


def turn_by_step(T: np.ndarray, free: Freedom, step_deg: float) -> np.ndarray:
    """Turn a pose T_target_source about a free axis until the whole motion turns by a known step [degrees].

    Positive steps are those of a camera that goes round counterclockwise seen from above (a camera's y points down).
    """
    step_deg = (step_deg + 180) % 360 - 180
    angles = np.radians(np.arange(0, 360, _FINENESS_DEG))
    whole = (Rotation.from_rotvec(angles[:, None] * free.axis) * Rotation.from_matrix(T[:3, :3])).as_rotvec()
    off = np.abs(np.linalg.norm(whole, axis=1) - abs(np.radians(step_deg)))
    off[np.sign(-whole[:, 1]) != np.sign(step_deg)] += 2 * np.pi
    return poses.turn_about(free.axis, free.point, angles[int(off.argmin())]) @ T
