"""Groups of turns that leave what is seen of an object unchanged: what they lead to, and which are the same."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import product

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.results.estimates import Freedom, Symmetry
from orbitscan.recorder import poses

_MOST_ORDER = 36  # turns by less than ten degrees are not told from a free turn
_LEAST_TURN_DEG = 5.0  # a smaller turn is none
_BETWEEN = (0.5, 0.382)  # of the way to the next turn of a symmetry: where these stand, any turn does
_AS_WELL = 5.0  # standard deviations by which a symmetry's turns explain the views worse on average, at most ...
_NO_BETTER = 1.0  # ... and more than those of another order about the axis do: 13 sides are nearly as good as 12
_LARGEST_GROUP = 120  # motions; the rotations of an icosahedron are 60
_SAME_TURN_DEG = 3.0  # two turns so near to each other are one
_SAME_AXIS_DEG, _SAME_AXIS_SHARE = 8.0, 0.05  # two axes that are one: degrees apart, share of the diameter apart


def expand(symmetries: Sequence[Symmetry]) -> list[np.ndarray]:
    """All motions (4, 4) that symmetries about one centre lead to, the identity first; too many are cut short."""
    found = [np.eye(4)]
    turns = [turn for symmetry in symmetries for turn in symmetry.turns()]
    if len(symmetries) < 2:
        return found + turns
    waiting = [np.eye(4)]
    while waiting and len(found) < _LARGEST_GROUP:
        fresh = []
        for D, turn in product(waiting, turns):
            moved = turn @ D
            angles = np.array([np.trace(moved[:3, :3].T @ other[:3, :3]) for other in found])
            if angles.max() < 1 + 2 * np.cos(np.radians(_SAME_TURN_DEG)):
                found.append(moved)
                fresh.append(moved)
        waiting = fresh
    return found[:_LARGEST_GROUP]


def name_turn(
    D: np.ndarray, center: np.ndarray, shift_limit: float, worse_by: Callable[[np.ndarray], float | None]
) -> Symmetry | Freedom | None:
    """Name the symmetry that a motion D (4, 4) of an object about its centre (3,) [m] is part of.

    It is the one of the highest order all of whose turns leave what is seen as it is, where no other order does so
    clearly better; a free turn where any angle does. None where the motion is hardly a turn, or shifts along its axis
    by more than the limit [m], or explains too badly. `worse_by` tells by how many standard deviations a turn explains
    the views worse; None: it is refuted; NaN: nothing tells.
    """
    turn = Rotation.from_matrix(D[:3, :3]).as_rotvec()
    angle = float(np.linalg.norm(turn))
    if np.degrees(angle) < _LEAST_TURN_DEG or (worse := worse_by(D)) is None or np.isnan(worse):
        return None
    axis = turn / angle
    along = float(axis @ (poses.transform(D, center[None])[0] - center))
    if abs(along) > shift_limit:
        return None
    point = np.linalg.lstsq(D[:3, :3] - np.eye(3), along * axis - D[:3, 3], rcond=1e-6)[0]
    point += axis * (axis @ (center - point))
    orders = [order for order in range(_MOST_ORDER, 1, -1) if _is_multiple(np.degrees(angle), 360 / order)]
    means = _explain_each([Symmetry(axis, point, order) for order in orders], worse_by)
    least = min(means.values(), default=np.inf)
    if least > _AS_WELL:
        return None
    symmetry = next(symmetry for symmetry, mean in means.items() if mean <= min(_AS_WELL, least + _NO_BETTER))
    between = [poses.turn_about(axis, point, 2 * np.pi / symmetry.order * share) for share in _BETWEEN]
    return Freedom("turn", axis, point) if all(map(_stands(worse_by), between)) else symmetry


def _stands(worse_by: Callable[[np.ndarray], float | None]) -> Callable[[np.ndarray], bool]:
    """What tells whether a turn is told of and not refuted."""

    def stands(turn: np.ndarray) -> bool:
        worse = worse_by(turn)
        return worse is not None and not np.isnan(worse)

    return stands


def _explain_each(
    symmetries: Sequence[Symmetry], worse_by: Callable[[np.ndarray], float | None]
) -> dict[Symmetry, float]:
    """Tell by how many deviations the turns of symmetries about one axis explain the views worse on average.

    Only of those none of whose turns is refuted, and whose least turn is told.
    """
    known: dict[Fraction, float | None] = {}  # by shares of a whole turn: many orders have the same ones
    means = {}
    for symmetry in symmetries:
        told: list[float] = []
        for k, turn in enumerate(symmetry.turns(), 1):
            share = Fraction(k, symmetry.order)
            if share not in known:
                known[share] = worse_by(turn)
            worse = known[share]
            if worse is None or (k == 1 and np.isnan(worse)):
                break
            if not np.isnan(worse):
                told.append(max(0.0, worse))
        else:
            means[symmetry] = float(np.mean(told))
    return means


def _is_multiple(angle: float, unit: float) -> bool:
    """Whether an angle is a multiple of a unit, all in degrees."""
    return abs(angle / unit - round(angle / unit)) * unit < min(_SAME_TURN_DEG, unit / 4)


def join(known: Sequence[Symmetry], more: Sequence[Symmetry], diameter: float) -> list[Symmetry]:
    """All symmetries, those once that others account for; the diameter [m] is the object's."""
    joined = list(known)
    for symmetry in more:
        if not is_among(joined, symmetry, diameter):
            joined = [other for other in joined if not is_among([symmetry], other, diameter)] + [symmetry]
    return joined


def find_agreed(told: Sequence[Symmetry], least: float, diameter: float) -> list[Symmetry]:
    """Find those of the symmetries that at least so many tell of; the diameter [m] is the object's."""
    counts = [sum(is_among([other], symmetry, diameter) for other in told) for symmetry in told]
    return join([], [symmetry for symmetry, count in zip(told, counts, strict=True) if count >= least], diameter)


def is_among(symmetries: Sequence[Symmetry], symmetry: Symmetry, diameter: float) -> bool:
    """Whether one of the symmetries has the axis of another, and all its turns; the diameter [m] is the object's."""
    return any(_same_axis(symmetry, other, diameter) and other.order % symmetry.order == 0 for other in symmetries)


def is_turn(freedoms: Sequence[Freedom], symmetry: Symmetry, diameter: float) -> bool:
    """Whether one of the free motions is any turn about a symmetry's axis; the diameter [m] is the object's."""
    return any(freedom.kind == "turn" and _same_axis(symmetry, freedom, diameter) for freedom in freedoms)


def _same_axis(a: Symmetry, b: Symmetry | Freedom, diameter: float) -> bool:
    apart = float(np.linalg.norm(np.cross(b.point - a.point, a.axis)))
    along = abs(float(a.axis @ b.axis))
    return along > np.cos(np.radians(_SAME_AXIS_DEG)) and apart < _SAME_AXIS_SHARE * diameter
