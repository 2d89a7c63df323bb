"""How well poses can be known from their own evidence: what a change must exceed to be more than chance.

A pair's overlap holds its pose by n independent patches of surface whose residual is rmse_m. Its weakest motion moves
the surface along its normals by the share `observability` (a mean square), so that motion is known to

    sigma = rmse / sqrt(n observability),    n = points * overlap / (pi q^2)

metres at the object's surface, which bounds all other motions. The surface at a point is a quadric fitted to what lies
within q working resolutions, and the working cloud has a point for each of their squares: residuals within a quadric
are not independent, a patch of its size counts once. It is the Cramer-Rao bound with the residual that was found in
place of the noise that was assumed; a turn by sigma / lever moves the surface by sigma. Along a chain of pairs the
squares add. A view's deviation is that of its best chain: a composed pose has no other, and that of a graph is known
better still.
"""

import heapq
import math
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from orbitscan.processing.results.estimates import PairEstimate
from orbitscan.processing.results.folder import ROUNDING, Results
from orbitscan.processing.results.status import Method, Status

_CALIBRATED = (Method.PAIRWISE, Method.REFINED)  # what sigma describes: they weigh every point by its noise


def pair_deviation(pair: PairEstimate, quadric_radius: float) -> float | None:
    """Sigma [m] of a pair; None where it is not ok or its evidence does not say."""
    e = pair.evidence
    if pair.status != Status.OK or not e.rmse_m or not e.overlap or not e.observability or e.observability <= 0:
        return None
    patches = e.points * e.overlap / max(math.pi * quadric_radius**2, 1.0)
    return max(e.rmse_m / math.sqrt(max(patches, 1.0) * e.observability), ROUNDING)


def view_deviations(pairs: Sequence[PairEstimate], origin: int, quadric_radius: float) -> dict[int, float]:
    """Sigma [m] of each view that a chain of pairs leads to from the origin; 0 of the origin itself."""
    neighbours: defaultdict[int, list[tuple[int, float]]] = defaultdict(list)
    for pair in pairs:
        if (sigma := pair_deviation(pair, quadric_radius)) is not None:
            neighbours[pair.source].append((pair.target, sigma**2))
            neighbours[pair.target].append((pair.source, sigma**2))
    variances: dict[int, float] = {}
    queue = [(0.0, origin)]
    while queue:
        variance, view = heapq.heappop(queue)
        if view not in variances:
            variances[view] = variance
            for other, step in neighbours[view]:
                heapq.heappush(queue, (variance + step, other))
    return {view: math.sqrt(variance) for view, variance in variances.items()}


def scale_of_errors(results: Results, lever: float, quadric_radius: float) -> float:
    """The median distance from the truth of the best method's sound pairs, in their sigmas, at least 1.

    Birge's ratio: real surfaces are distorted, and a truth may come from a registration itself. What nobody can be
    nearer to is no change. 1 without truth, and where only methods were run that sigma does not describe.
    """
    found = [
        _ratios(results.reconstruction[m].pairs, lever, quadric_radius)
        for m in _CALIBRATED
        if m in results.reconstruction
    ]
    return max(1.0, min((float(np.median(ratios)) for ratios in found if ratios), default=1.0))


def _ratios(pairs: Sequence[PairEstimate], lever: float, quadric_radius: float) -> list[float]:
    found = []
    for pair in pairs:
        sigma = pair_deviation(pair, quadric_radius)
        degrees, metres = pair.errors.rotation_error_deg_observable, pair.errors.center_error_m_observable
        if sigma is not None and degrees is not None and metres is not None:
            found.append(max(metres, math.radians(degrees) * lever) / sigma)
    return found
