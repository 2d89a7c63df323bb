"""The turntable behind the poses: its axis, its step, and how each view departs from a perfect turn."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.processing.results.records import Turntable, TurntableDeviation
from orbitscan.processing.results.status import WRONG_DEG
from orbitscan.recorder import poses

_FEWEST_EVEN = 6  # views that tell whether most steps agree
_EVEN_DEG = 1.0  # steps agree that differ by no more


@dataclass(frozen=True)
class TurntableSettings:
    """When poses are called a turntable's; not in the thesis."""

    min_views: int = 3
    min_turn_deg: float = 10.0  # from the first to the farthest view
    max_wobble_deg: float = 5.0  # median; more, and the views do not turn about one axis
    max_unevenness: float = 0.5  # median departure from the median step, as its share; more, and there is no step


def fit_turntable(T_0: Mapping[int, np.ndarray], settings: TurntableSettings) -> Turntable | None:
    """Fit the turn that the poses T_0_i (by view, in capture order) share; None for too few, or where they share none.

    The axis a is what all rotations leave alone: it minimises sum |R_i a - a|^2; a point c of it is left alone by the
    motions: it minimises sum |R_i c + t_i - c|^2. The step is the median turn from view to view, per recorded index.
    """
    views = list(T_0)
    if len(views) < settings.min_views:
        return None
    R = np.array([T_0[view][:3, :3] for view in views])
    t = np.array([T_0[view][:3, 3] for view in views])
    M = (R - np.eye(3)).reshape(-1, 3)
    turned = np.degrees(Rotation.from_matrix(R).magnitude())
    if turned.max() < settings.min_turn_deg:
        return None
    axis = np.linalg.svd(M)[2][2]
    point = np.linalg.lstsq(M, -t.ravel(), rcond=1e-6)[0]
    angles = np.array([poses.twist(rotation, axis) for rotation in R])
    steps = np.degrees((np.diff(angles) + np.pi) % (2 * np.pi) - np.pi) / np.diff(views)
    step = float(np.median(steps))
    if np.median(np.abs(steps - step)) > settings.max_unevenness * abs(step):
        return None
    if step < 0:
        axis, angles, step = -axis, -angles, -step
    expected = np.radians(step) * (np.array(views) - views[0])
    slip = np.degrees((angles - expected + np.pi) % (2 * np.pi) - np.pi)
    slip -= np.median(slip)
    wobble = np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(R @ axis - axis, axis=1) / 2, 0, 1)))
    if np.median(wobble) > settings.max_wobble_deg:
        return None
    shifts = R @ point + t - point
    deviations = tuple(
        TurntableDeviation(view, float(s), float(w), float(np.linalg.norm(shift)))
        for view, s, w, shift in zip(views, slip, wobble, shifts, strict=True)
    )
    return Turntable(axis, point, step, deviations)


def find_slips(T_0: Mapping[int, np.ndarray], settings: TurntableSettings | None = None) -> dict[int, float]:
    """Find the views (poses T_0_i, in capture order) that slip from an otherwise even turn: by how many degrees.

    Where most steps agree, such a view has turned more or less than both of its neighbours, which agree. A turntable
    that was moved once, and a second turn that begins elsewhere, are even before and after it.
    """
    turntable = fit_turntable(T_0, settings or TurntableSettings())
    if turntable is None or len(turntable.deviations) < _FEWEST_EVEN:
        return {}
    slips = np.array([deviation.slip_deg for deviation in turntable.deviations])
    uneven = np.abs((np.diff(slips) + 180) % 360 - 180)
    if np.mean(uneven <= _EVEN_DEG) <= 0.5:
        return {}
    found = {}
    for before, deviation, after in zip(slips[:-2], turntable.deviations[1:-1], slips[2:], strict=True):
        off = [(deviation.slip_deg - other + 180) % 360 - 180 for other in (before, after)]
        if min(map(abs, off)) > WRONG_DEG and abs(off[0] - off[1]) <= _EVEN_DEG:
            found[deviation.view] = abs(off[0])
    return found
