"""What all pairs of a session say of each view and pair: how well it is known, and what speaks against it.

A pose that explains its own pair perfectly may be that of what stands still, or hang on a single pair that another one
contradicts, or slip from an even turn.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from orbitscan.processing.reconstruction.disputes import find_disputed
from orbitscan.processing.reconstruction.graph_uncertainty import measure_graph
from orbitscan.processing.reconstruction.turntable import find_slips
from orbitscan.processing.results.estimates import PairEstimate, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.recorder import poses

_STILL_DEG, _STILL_SHARE = 1.0, 0.01  # a view that turns and shifts (share of the diameter) by less stands still
STILL = "nothing moves from view to view: what was registered may be what stands still"
SLIPS = "it is {:.1f}° off an even turn that the views before and after keep to"
DISPUTED = "a single pair connects it to the first view, and another pair that seems right says otherwise"


def judge_views(
    views: Sequence[ViewEstimate],
    pairs: Sequence[PairEstimate],
    origin: int,
    diameter: float,
    contradicting: Sequence[PairEstimate] = (),
) -> list[ViewEstimate]:
    """Return views with their bounds, `ambiguous` where these allow an ok one to be wrong.

    `inconsistent` are views in dispute (see `disputes`), views that slip from an even turn (see `find_slips`), and all
    where nothing moves. `pairs` are those that nothing contradicts; the ok ones connect all ok views. `contradicting`
    are those that seem right but for the others. The diameter [m] is the object's.
    """
    T_0 = _place_ok(views)
    holding = _find_holding(pairs, T_0)
    if not holding:
        return [replace(v, rotation_bound_deg=0.0, center_bound_m=0.0) if v.view == origin else v for v in views]
    center = _find_center(holding, T_0)
    doubts: dict[int, str] = {}
    if not any(_moves(T, center, diameter) for T in T_0.values()):
        doubts = dict.fromkeys(T_0.keys() - {origin}, STILL)
    doubts |= {view: SLIPS.format(deg) for view, deg in find_slips(T_0).items() if view != origin}
    doubts |= dict.fromkeys(find_disputed([p.ends for p in holding], [p.ends for p in contradicting], origin), DISPUTED)
    bounds = {origin: Uncertainty(np.zeros((6, 6)), center)} | measure_graph(holding, T_0, center, origin)
    return [_judge(view, bounds.get(view.view), doubts.get(view.view), diameter) for view in views]


def bound_centers(pairs: Sequence[PairEstimate], views: Sequence[ViewEstimate]) -> list[PairEstimate]:
    """Return pairs, the shift that is possible at the object's middle in the place of that at the source's.

    Where no view is ok nobody knows where the object's middle is.
    """
    T_0 = _place_ok(views)
    holding = _find_holding(pairs, T_0)
    if not holding:
        return list(pairs)
    center, moved = _find_center(holding, T_0), []
    for pair in pairs:
        if pair.covariance is not None and pair.center is not None and pair.target in T_0:
            in_target = poses.transform(poses.invert(T_0[pair.target]), center[None])[0]
            known = Uncertainty(pair.covariance, pair.center).about(in_target)
            pair = replace(pair, center_bound_m=known.center_bound_m)
        moved.append(pair)
    return moved


def _find_center(pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray]) -> np.ndarray:
    """Find the middle (3,) of the object in frame {0}: the mean of the middles of what the pairs' sources show."""
    middles = {p.source: poses.transform(T_0[p.target], p.center[None])[0] for p in pairs if p.center is not None}
    return np.mean(list(middles.values()), axis=0)


def _judge(view: ViewEstimate, known: Uncertainty | None, doubt: str | None, diameter: float) -> ViewEstimate:
    """A view with its bounds; what speaks against it says why."""
    if known is None or view.status != Status.OK:
        return view
    status = Status.OK if known.is_good(diameter) else Status.AMBIGUOUS
    if doubt is not None:
        return replace(view, status=Status.INCONSISTENT, note=doubt)
    return replace(
        view, status=status, rotation_bound_deg=known.rotation_bound_deg, center_bound_m=known.center_bound_m
    )


def _place_ok(views: Sequence[ViewEstimate]) -> dict[int, np.ndarray]:
    return {view.view: view.T_0_i for view in views if view.status == Status.OK and view.T_0_i is not None}


def _find_holding(pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray]) -> list[PairEstimate]:
    """The ok pairs of ok views."""
    return [pair for pair in pairs if pair.status == Status.OK and pair.source in T_0 and pair.target in T_0]


def _moves(T_0_i: np.ndarray, center: np.ndarray, diameter: float) -> bool:
    """Whether a view is turned, or its points' centre (3,) shifted, against the first view."""
    shift = float(np.linalg.norm(center - poses.transform(poses.invert(T_0_i), center[None])[0]))
    return bool(np.degrees(poses.rotation_angle(T_0_i[:3, :3])) > _STILL_DEG or shift > _STILL_SHARE * diameter)
