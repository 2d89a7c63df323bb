"""The edges of the joint refinement's graph: which hold a view, which the others contradict, by how much."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from orbitscan.processing.results.estimates import MethodResult, PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses


@dataclass(frozen=True)
class Disagreement:
    """How far an edge is from where the poses put its source."""

    degrees: float
    metres: float  # at the centre of the overlap


def count_edges(pairs: Sequence[PairEstimate]) -> Counter[int]:
    """View -> how many edges hold it, those left out not counted."""
    return Counter(view for pair in pairs if pair.status != Status.INCONSISTENT for view in (pair.source, pair.target))


def left_out(found: MethodResult) -> list[tuple[PairEstimate, Disagreement | None]]:
    """The edges that the graph leaves out, and how far they disagree with it; None where it has no say there."""
    T_0 = {view.view: view.T_0_i for view in found.views if view.T_0_i is not None}
    return [(pair, _disagreement(pair, T_0)) for pair in found.pairs if pair.status == Status.INCONSISTENT]


def _disagreement(pair: PairEstimate, T_0: Mapping[int, np.ndarray]) -> Disagreement | None:
    if pair.T_target_source is None or pair.source not in T_0 or pair.target not in T_0:
        return None
    by_graph = poses.invert(T_0[pair.target]) @ T_0[pair.source]
    D = by_graph @ poses.invert(pair.T_target_source)
    center = np.zeros(3) if pair.center is None else pair.center
    moved = poses.transform(D, center[None])[0] - center
    return Disagreement(float(np.degrees(poses.rotation_angle(D[:3, :3]))), float(np.linalg.norm(moved)))
