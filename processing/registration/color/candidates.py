"""Which poses of a pair its colours might bear out: those that explain its shapes, and what corners propose."""

from collections.abc import Sequence

import numpy as np

from orbitscan.processing.registration.ambiguity.symmetry import expand
from orbitscan.processing.registration.color.alignment import approach_by_color
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.registration.color.proposals import propose_by_color
from orbitscan.processing.registration.covisibility import Explanation
from orbitscan.processing.results.estimates import Freedom, PairEstimate
from orbitscan.recorder import poses

_MOST = 12  # poses, the best at a first look
_FROM = 4  # poses from which free motions are looked along
_STEP_DEG = 4.0  # of a free turn, of which every angle is looked at
_STEP_SHARE, _FARTHEST = 0.02, 0.5  # of a free shift, and the farthest: shares of the diameter
_SKIPPED, _ALIKE = 8, 1.0  # of these, one in so many tells whether they differ, by more standard deviations than that
_HOPELESS = 3.0  # times what refutes a pose, at a first look: alignment will not mend it
_SAME, _APPROACHED = 0.3, 2.0  # how near ends are that are one, where 1 is distinct; and what refutes one, once aligned
_SEVERAL = 3


def look_everywhere(colors: ColorPair, estimate: PairEstimate) -> list[np.ndarray]:
    """The distinct poses (4, 4) that may explain an estimate's shapes and colours, best first at a first look.

    They are its turns and alternatives, where colours agree best along its free motions from there, and those that
    corners of its colours propose.
    """
    T, pair = estimate.T_target_source, colors.pair
    found = [turn @ T for turn in expand(estimate.symmetries)] + list(estimate.alternatives) if T is not None else []
    for freedom in estimate.freedoms:
        along = [end for start in found[:_FROM] for end in _look_along(colors, start, freedom)]
        found = _sort(colors, [*found, *along])[:_MOST]
    return _sort(colors, [*found, *propose_by_color(pair.source, pair.target, pair.settings)])


def choose_likely(colors: ColorPair, found: Sequence[np.ndarray]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Those of the poses, best first, that may be right by their colours and show contrast; and those that may not."""
    seen = [(T, told) for T in found if len((told := colors.explain(T, coarse=True)).squares)]
    limit, least = _HOPELESS * colors.refuted, min((_misfit(colors, T) for T, _ in seen), default=0.0)
    worse = [told.worse_than(seen[0][1]) for _, told in seen]
    likely = [T for (T, _), by in zip(seen, worse, strict=True) if by <= limit and colors.has_contrast(T, least)]
    return likely[:_MOST], [T for (T, _), by in zip(seen, worse, strict=True) if by > limit]


def tell_along(colors: ColorPair, T: np.ndarray, freedom: Freedom) -> bool:
    """Tell whether colours may hold a free motion: not where they are explained, and as well, all along it.

    Bands around a mug, or a box of one colour on each side, say nothing of the motions that lead along them.
    """
    path = [T, *_path(colors, T, freedom)[::_SKIPPED]]
    seen = [(pose, told) for pose in path if len((told := colors.explain(pose, coarse=True)).squares)]
    if not seen:
        return False
    where, best = min(seen, key=lambda found: found[1].misfit(colors.least))
    differ = any(told.worse_than(best) > _ALIKE for _, told in seen)
    return differ or colors.is_unexplained(where, best.misfit(colors.least))


def _look_along(colors: ColorPair, T: np.ndarray, freedom: Freedom) -> list[np.ndarray]:
    """Where, along a free motion from a pose, colours agree better than a little before and after."""
    path = _path(colors, T, freedom)
    misfits = np.array([_misfit(colors, pose) for pose in path])
    better = (misfits <= np.roll(misfits, 1)) & (misfits < np.roll(misfits, -1))
    return [path[k] for k in np.flatnonzero(better)]


def _path(colors: ColorPair, T: np.ndarray, freedom: Freedom) -> list[np.ndarray]:
    """The poses along a free motion from one."""
    if freedom.kind == "turn":
        angles = np.radians(np.arange(0, 360, _STEP_DEG))
        return [poses.turn_about(freedom.axis, freedom.point, angle) @ T for angle in angles]
    far = np.arange(-_FARTHEST, _FARTHEST, _STEP_SHARE) * colors.pair.diameter
    return [poses.make(np.eye(3), size * freedom.axis) @ T for size in far]


def _misfit(colors: ColorPair, T: np.ndarray) -> float:
    return colors.explain(T, coarse=True).misfit(colors.least)


def approach(colors: ColorPair, likely: Sequence[np.ndarray], free: bool) -> list[np.ndarray]:
    """Align the likely poses by the coarse surfels: the distinct ends, best first, that colours do not refute there.

    None where motions are free and several ends are alike: colours do not hold what shapes leave free.
    """
    ends: list[tuple[np.ndarray, Explanation]] = []
    for T in (approach_by_color(colors, start) for start in likely):
        told = colors.explain(T, coarse=True)
        if len(told.squares) and all(colors.pair.distance(T, other) > _SAME for other, _ in ends):
            ends.append((T, told))
        ends.sort(key=lambda end: end[1].misfit(colors.least))
        if free and len(ends) >= _SEVERAL and ends[_SEVERAL - 1][1].worse_than(ends[0][1]) <= _ALIKE:
            return []
    return [T for T, told in ends if told.worse_than(ends[0][1]) <= _APPROACHED * colors.refuted]


def _sort(colors: ColorPair, found: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The poses that are distinct, those first whose colours agree best."""
    kept: list[np.ndarray] = []
    for T in sorted(found, key=lambda T: _misfit(colors, T)):
        if all(colors.pair.distance(T, other) > 1.0 for other in kept):
            kept.append(T)
    return kept
