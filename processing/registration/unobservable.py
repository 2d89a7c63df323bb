"""What follows from a motion that views leave free: for information, for comparing poses, for naming it once."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.results.records import Freedom
from orbitscan.recorder import poses

_FINENESS_DEG = 0.02  # of the turns looked at for a known step
_ROUNDS = 5  # of taking out one free motion after the other, where there are several


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
