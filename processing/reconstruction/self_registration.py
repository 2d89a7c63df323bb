"""The object registered with itself: turns that change nothing of what all views together show.

Two views may not tell that an object repeats itself: neighbours of a box see nothing that is alike. All of them do.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from orbitscan.processing.kernels.blas import SingleThreaded
from orbitscan.processing.reconstruction.partners import viewing_direction
from orbitscan.processing.registration.ambiguity.symmetry import join, name_turn
from orbitscan.processing.registration.color.comparison import ColorPair
from orbitscan.processing.registration.correspondences import make_target
from orbitscan.processing.registration.covisibility import Explanation
from orbitscan.processing.registration.pair import PairRegistration, PairSettings
from orbitscan.processing.registration.prepared_view import PreparedView, ViewCache
from orbitscan.processing.registration.surface_icp import align_coarsely
from orbitscan.processing.results.estimates import Symmetry
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

_VIEWS = 24  # that are looked at, at most
_SURFELS = 1500  # that stand for the whole object
_ANGLES = 12  # of a whole turn that are tried about an axis
_ALIKE = 0.5  # share of a view's surface that must lie on the view of the place where a turn brings it
_TOLD = 0.5  # share of them for which there is a view of that place: a turn upside down brings them where none is
_LOOKED_AT = 8  # views, spread over all, that must explain a turn
_SAME_TURN = np.radians(3.0)  # two turns so near to each other are one
_SAME_SIDE = 0.7  # cosine between two views' directions from which on they see the same side


def find_self_symmetries(
    cache: ViewCache,
    T_0: Mapping[int, np.ndarray],
    suspected: Sequence[np.ndarray],
    usual: Explanation,
    settings: PairSettings,
) -> list[Symmetry]:
    """Find the symmetries, in frame {0}, of what placed views show together; pairs tell of suspected turns (4, 4).

    `usual` is how a pair that is right explains what both see: a turn must do so as well in each of the views that it
    brings over another. Of many views some are looked at, spread over all. Empty for fewer than three.
    """
    if len(T_0) < 3:
        return []
    views, T_0 = _choose(cache, T_0)
    first = next(iter(views.values()))
    w, diameter, how = first.scale.working, first.scale.diameter, settings.refinement
    merged = _merge(views, T_0)
    target = make_target(merged, how.coarse_gate * w)
    center = merged.points.mean(axis=0)
    axes = np.linalg.svd(merged.points - center, full_matrices=False)[2]
    angles = 2 * np.pi * np.arange(1, _ANGLES) / _ANGLES
    starts = np.array([poses.turn_about(axis, center, float(angle)) for axis in axes for angle in angles])
    starts = np.concatenate([starts, np.array(suspected).reshape(-1, 4, 4)])
    ends = align_coarsely(
        merged, target, starts, how.coarse_gate * w, how.coarse_deviation * w, how.coarse_iterations, how.coarse_still
    )
    stands = _judge(views, T_0, usual, settings, PairRegistration.explain)
    found: list[Symmetry] = []
    for end in _keep_distinct(ends):
        symmetry = name_turn(end, center, diameter * settings.judgement.distinct_shift, stands)
        if isinstance(symmetry, Symmetry):
            found = join(found, [symmetry], diameter)
    return found


@SingleThreaded()
def tell_by_color(
    cache: ViewCache,
    T_0: Mapping[int, np.ndarray],
    symmetries: Sequence[Symmetry],
    usual: Explanation | None,
    settings: PairSettings,
) -> list[Symmetry]:
    """Return symmetries of the shape, with word of which the object's colours tell apart; and those that both have.

    `usual` is how a pair that is right explains the colours of what both see; None where there are none.
    """
    if usual is None or not symmetries:
        return list(symmetries)
    stands = _judge(*_choose(cache, T_0), usual, settings, _explain_colors)
    found = []
    for symmetry in symmetries:
        orders = [order for order in range(symmetry.order, 1, -1) if symmetry.order % order == 0]
        alike = [of_both for order in orders if _is_seen(of_both := replace(symmetry, order=order), stands)]
        if symmetry not in alike:
            found.append(replace(symmetry, told_by_color=True))
        found += alike[:1]
    return found


def _is_seen(symmetry: Symmetry, stands: Callable[[np.ndarray], float | None]) -> bool:
    """Whether views tell of every turn of a symmetry, and none refutes it."""
    return all((worse := stands(turn)) is not None and not np.isnan(worse) for turn in symmetry.turns())


def _explain_colors(pair: PairRegistration, T: np.ndarray) -> Explanation:
    colors = ColorPair.of(pair)
    return pair.explain(T) if colors is None else colors.explain(T)


def _choose(cache: ViewCache, T_0: Mapping[int, np.ndarray]) -> tuple[dict[int, PreparedView], dict[int, np.ndarray]]:
    """Some of many views, spread over all, and their poses."""
    views = {view: cache.get_surface(view) for view in list(T_0)[:: -(-len(T_0) // _VIEWS)]}
    return views, {view: T_0[view] for view in views}


def _keep_distinct(turns: np.ndarray) -> list[np.ndarray]:
    """Those of the turns (B, 4, 4) that differ from all before them."""
    kept: list[np.ndarray] = []
    for turn in turns:
        if all(poses.rotation_angle(turn[:3, :3].T @ other[:3, :3]) > _SAME_TURN for other in kept):
            kept.append(turn)
    return kept


def _merge(views: Mapping[int, PreparedView], T_0: Mapping[int, np.ndarray]) -> Surfels:
    parts = [views[view].coarse_surfels.thinned(max(50, _SURFELS // len(T_0))) for view in T_0]
    placed = zip(parts, T_0.values(), strict=True)
    points, normals = zip(*((poses.transform(T, s.points), poses.rotate(T, s.normals)) for s, T in placed), strict=True)
    return Surfels(np.concatenate(points), np.concatenate(normals), np.concatenate([s.variances for s in parts]))


def _judge(
    views: Mapping[int, PreparedView],
    T_0: Mapping[int, np.ndarray],
    usual: Explanation,
    settings: PairSettings,
    explain: Callable[[PairRegistration, np.ndarray], Explanation],
) -> Callable[[np.ndarray], float | None]:
    """What tells by how many deviations a turn in frame {0} explains the views worse than usual (see `name_turn`)."""
    directions = {}
    for view, T in T_0.items():
        directions[view] = viewing_direction(T, views[view].middle, views[view].surface.sensor_origin)
    some = list(T_0)[:: max(1, len(T_0) // _LOOKED_AT)]

    def worse_by(turn: np.ndarray) -> float | None:
        worse = []
        for view in some:
            towards = turn[:3, :3] @ directions[view]
            other = max(directions, key=lambda candidate: float(directions[candidate] @ towards))
            if directions[other] @ towards < _SAME_SIDE:
                continue
            pair = PairRegistration(views[view], views[other], settings)
            T = poses.invert(T_0[other]) @ turn @ T_0[view]
            worse.append(explain(pair, T).worse_than(usual))
            if worse[-1] > settings.covisibility.worse or pair.verify(T, coarse=True).overlap < _ALIKE:
                return None
        return float(np.mean(worse)) if len(worse) >= _TOLD * len(some) else np.nan

    return worse_by
