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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

ROUNDING = 1e-9  # metres: the arithmetic itself is no better
_CALIBRATED = ("pairwise", "refined")  # what sigma describes: they weigh every point by its noise


@dataclass(frozen=True, eq=False)
class Extent:
    """Where an object is in frame {0}, and how large."""

    center: np.ndarray  # (3,) metres
    lever: float  # rms distance of its points from the centre [m]
    diameter: float  # [m]
    points: int

    @classmethod
    def of(cls, points: np.ndarray) -> Self:
        """That of points (N, 3)."""
        points = np.asarray(points, dtype=np.float64)
        center = points.mean(axis=0)
        lever = float(np.sqrt(((points - center) ** 2).sum(axis=1).mean()))
        low, high = np.percentile(points, [1, 99], axis=0)
        return cls(center, max(lever, ROUNDING), float(np.linalg.norm(high - low)), len(points))


def pair_deviation(pair: Mapping[str, Any], quadric_radius: float) -> float | None:
    """Sigma [m] of a pair as results.json has it; None where it is not ok or its evidence does not say."""
    evidence = pair["evidence"]
    rmse, overlap, held = (evidence[name] for name in ("rmse_m", "overlap", "observability"))
    if pair["status"] != "ok" or not rmse or not overlap or not held or held <= 0:
        return None
    patches = evidence["points"] * overlap / max(math.pi * quadric_radius**2, 1.0)
    return max(rmse / math.sqrt(max(patches, 1.0) * held), ROUNDING)


def view_deviations(pairs: Sequence[Mapping[str, Any]], origin: int, quadric_radius: float) -> dict[int, float]:
    """Sigma [m] of each view that a chain of pairs leads to from the origin; 0 of the origin itself."""
    neighbours: defaultdict[int, list[tuple[int, float]]] = defaultdict(list)
    for pair in pairs:
        if (sigma := pair_deviation(pair, quadric_radius)) is not None:
            neighbours[pair["source"]].append((pair["target"], sigma**2))
            neighbours[pair["target"]].append((pair["source"], sigma**2))
    variances: dict[int, float] = {}
    queue = [(0.0, origin)]
    while queue:
        variance, view = heapq.heappop(queue)
        if view not in variances:
            variances[view] = variance
            for other, step in neighbours[view]:
                heapq.heappush(queue, (variance + step, other))
    return {view: math.sqrt(variance) for view, variance in variances.items()}


def scale_of_errors(results: Mapping[str, Any], lever: float, quadric_radius: float) -> float:
    """How many sigmas the sound pairs of the best method are off the truth in the middle, at least 1.

    Birge's ratio: real surfaces are distorted, and a truth may come from a registration itself. What nobody can be
    nearer to is no change. 1 without truth, and where only methods were run that sigma does not describe.
    """
    ratios = {
        method: np.median(found)
        for method in _CALIBRATED
        if (found := list(_ratios(results["reconstruction"].get(method), lever, quadric_radius)))
    }
    return max(1.0, float(min(ratios.values(), default=1.0)))


def _ratios(method: Mapping[str, Any] | None, lever: float, quadric_radius: float) -> list[float]:
    found = []
    for pair in method["pairs"] if method else ():
        sigma = pair_deviation(pair, quadric_radius)
        degrees, metres = pair["rotation_error_deg_observable"], pair["center_error_m_observable"]
        if sigma is not None and degrees is not None and metres is not None:
            found.append(max(metres, math.radians(degrees) * lever) / sigma)
    return found
