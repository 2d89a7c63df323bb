"""A view registered with itself: other poses than the identity under which it agrees with itself.

Where a view repeats itself, so may the object, and a pair of views that looks certain is not: what one shows may be the
other's neighbouring side. Features tell what repeats itself at corners; flat sides, which have none, are tried here.
"""

from itertools import permutations

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.recorder import poses

_SIDES = 5  # at most, the largest
_LEAST = 0.08  # share of the surfels that make a side
_FLAT_DEG = 8.0  # normals so near to each other are of one side
_MOST = 6  # motions
_QUARTERS = (90.0, 180.0, 270.0)  # that a side is turned by in its plane


def find_self_turns(view: PreparedView, settings: PairSettings) -> tuple[np.ndarray, ...]:
    """Find the motions (4, 4) of a view, none the identity, under which geometry does not contradict it."""
    pair, belief, how = PairRegistration(view, view, settings), settings.judgement, settings.refinement
    starts = _exchange_sides(view)
    if not len(starts):
        return ()
    found: list[np.ndarray] = []
    for T in pair.align_coarsely(starts, how.coarse_gate, how.coarse_deviation):
        if any(pair.distance(T, other) <= 1.0 for other in (np.eye(4), *found)):
            continue
        agrees = pair.verify(T, coarse=True)
        if agrees.overlap >= belief.min_overlap / 2 and agrees.violations <= belief.max_violations:
            found.append(T)
    return tuple(found[:_MOST])


def _exchange_sides(view: PreparedView) -> np.ndarray:
    """Motions (B, 4, 4) that bring one flat side of a view onto another, or turn it in its own plane."""
    points, normals = view.coarse_surfels.points, view.coarse_surfels.normals
    rest = np.ones(len(points), bool)
    near = normals @ normals.T > np.cos(np.radians(_FLAT_DEG))
    sides: list[tuple[np.ndarray, np.ndarray]] = []
    while len(sides) < _SIDES:
        counts = (near & rest).sum(axis=1) * rest
        first = int(counts.argmax())
        if counts[first] < _LEAST * len(points):
            break
        members = near[first] & rest
        sides.append((points[members].mean(axis=0), normals[first]))
        rest &= ~members
    starts = []
    for (center, normal), (other, facing) in permutations(sides, 2):
        axis = np.cross(normal, facing)
        length = float(np.linalg.norm(axis))
        if length > 0:
            R = Rotation.from_rotvec(axis / length * np.arctan2(length, normal @ facing)).as_matrix()
            starts.append(poses.make(R, other - R @ center))
    for center, normal in sides:
        starts += [poses.turn_about(normal, center, float(np.radians(angle))) for angle in _QUARTERS]
    return np.array(starts).reshape(-1, 4, 4)
