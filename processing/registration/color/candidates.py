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
_APPROACHED = 2.0  # times it, once aligned by the coarse surfels
_SEVERAL = 3  # ends that are alike

Seen = tuple[np.ndarray, Explanation]  # a pose (4, 4), and how it explains the colours of coarse surfels


def look_everywhere(colors: ColorPair, estimate: PairEstimate) -> list[Seen]:
    """The distinct poses (4, 4) that may explain an estimate's shapes and colours, best first at a first look.

    They are its turns and alternatives, where colours agree best along its free motions from there, and those that
    corners of its colours propose.
    """
    T, pair = estimate.T_target_source, colors.pair
    found = [turn @ T for turn in expand(estimate.symmetries)] + list(estimate.alternatives) if T is not None else []
    for freedom in estimate.freedoms:
        along = [end for start in found[:_FROM] for end in _look_along(colors, start, freedom)]
        found = [pose for pose, _ in _sort(colors, [_look(colors, pose) for pose in (*found, *along)])[:_MOST]]
    found += [*propose_by_color(pair.source, pair.target, pair.settings)]
    return _sort(colors, [_look(colors, pose) for pose in found])


def choose_likely(colors: ColorPair, found: Sequence[Seen]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Those of the poses, best first, that may be right by their colours and show contrast; and those that may not."""
    seen = [(T, told) for T, told in found if len(told.squares)]
    limit, least = _HOPELESS * colors.refuted, seen[0][1].misfit(colors.least) if seen else 0.0
    worse = [told.worse_than(seen[0][1]) for _, told in seen]
    likely = [T for (T, _), by in zip(seen, worse, strict=True) if by <= limit and colors.has_contrast(T, least)]
    return likely[:_MOST], [T for (T, _), by in zip(seen, worse, strict=True) if by > limit]


def tell_along(colors: ColorPair, T: np.ndarray, freedom: Freedom) -> bool:
    """Tell whether colours may hold a free motion: not where they are explained, and as well, all along it.

    Bands around a mug, or a box of one colour on each side, say nothing of the motions that lead along them.
    """
    (where, best), *others = _sort(colors, [_look(colors, pose) for pose in _path(colors, T, freedom)[::_SKIPPED]])
    if not len(best.squares):
        return False
    differ = any(told.worse_than(best) > _ALIKE for _, told in others if len(told.squares))
    return differ or colors.is_unexplained(where, best.misfit(colors.least))


def approach(colors: ColorPair, likely: Sequence[np.ndarray], free: bool) -> list[np.ndarray]:
    """Align the likely poses by the coarse surfels: the distinct ends, best first, that colours do not refute there.

    None where motions are free and several ends are alike: colours do not hold what shapes leave free.
    """
    ends: list[Seen] = []
    for start in likely:
        ends = _sort(colors, [*ends, _look(colors, approach_by_color(colors, start))])
        if free and len(ends) >= _SEVERAL and ends[_SEVERAL - 1][1].worse_than(ends[0][1]) <= _ALIKE:
            return []
    return [T for T, told in ends if told.worse_than(ends[0][1]) <= _APPROACHED * colors.refuted]


def _look_along(colors: ColorPair, T: np.ndarray, freedom: Freedom) -> list[np.ndarray]:
    """Where, along a free motion from a pose, colours agree better than a little before and after."""
    path = _path(colors, T, freedom)
    misfits = np.array([_look(colors, pose)[1].misfit(colors.least) for pose in path])
    better = (misfits <= np.roll(misfits, 1)) & (misfits < np.roll(misfits, -1))
    return [path[k] for k in np.flatnonzero(better)]


def _path(colors: ColorPair, T: np.ndarray, freedom: Freedom) -> list[np.ndarray]:
    """The poses along a free motion from one."""
    if freedom.kind == "turn":
        angles = np.radians(np.arange(0, 360, _STEP_DEG))
        return [poses.turn_about(freedom.axis, freedom.point, angle) @ T for angle in angles]
    far = np.arange(-_FARTHEST, _FARTHEST, _STEP_SHARE) * colors.pair.diameter
    return [poses.make(np.eye(3), size * freedom.axis) @ T for size in far]


def _look(colors: ColorPair, T: np.ndarray) -> Seen:
    return T, colors.explain(T, coarse=True)


def _sort(colors: ColorPair, found: Sequence[Seen]) -> list[Seen]:
    """The poses that are distinct, those first whose colours agree best."""
    kept: list[Seen] = []
    for T, told in sorted(found, key=lambda seen: seen[1].misfit(colors.least)):
        if all(colors.pair.distance(T, other) > 1.0 for other, _ in kept):
            kept.append((T, told))
    return kept
