"""Joint refinement: a graph of overlapping views whose pairs are all registered, solved for all poses at once."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np

from orbitscan.processing.reconstruction.components import Component, Ends, find_components, label_groups
from orbitscan.processing.reconstruction.graph_solver import Measurements, invert_all, relax
from orbitscan.processing.results.estimates import PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

_QUARTER = 0.25  # the weight of an edge that disagrees as `GraphSettings.outlier` says


@dataclass(frozen=True)
class GraphSettings:
    """Which pairs become edges, and how the graph is solved; not in the thesis."""

    # Of views that stand close to each other keyviews are registered as if nothing were known; those between them are
    # aligned to the nearest from where the pairs of successive views put them.
    keyview_deg: float = 10.0  # between the viewing directions of keyviews, at least

    # An edge for every keyview in each band of angles between viewing directions, from 0 on: near ones are exact, far
    # ones keep errors from adding up.
    bands_deg: tuple[float, ...] = (10.0, 30.0, 50.0, 75.0)

    # A view that nothing holds is registered to views that hold together, by how well a first look at both agrees.
    tries: int = 12  # at most
    promising: float = 0.4  # a first look with a lower score, at most 1, is weak ...
    weak_tries: int = 3  # ... and no longer followed after so many tries
    open_tries: int = 4  # that may leave something open: then the view itself does
    vouching: int = 2  # recorded views apart, at most, where the two nearly slide: only a neighbour vouches for those

    # Three edges that close up to this vouch for each other: first poses go along the best vouched for.
    triangle_deg: float = 3.0
    triangle_shift: float = 0.03  # share of the diameter

    # An edge is left out that disagrees with the others in proportion and in absolute terms.
    outlier: float = 5.0  # times what is usual, in standard deviations: such an edge counts a quarter
    contradiction_deg: float = 1.5  # and it is off by more than this angle ...
    contradiction_shift: float = 0.02  # ... or this share of the diameter

    iterations: int = 20

    # Free motions of two edges are one whose axes are so near to each other.
    same_axis_deg: float = 10.0
    same_axis_shift: float = 0.1  # share of the diameter


@dataclass(frozen=True, eq=False)
class Solution:
    """All poses at once."""

    components: tuple[Component, ...]  # every view is in one; that of most rigid views is the first
    kept: tuple[bool, ...]  # of each edge: whether nothing contradicts it

    @property
    def origin(self) -> int:
        """The view whose frame is {0}."""
        return self.components[0].first

    @property
    def T_0(self) -> Mapping[int, np.ndarray]:
        """View -> T_0_i of the views of the largest component."""
        return self.components[0].T

    @property
    def rigid(self) -> frozenset[int]:
        """Those of them that edges connect to view {0} which leave nothing open."""
        return self.components[0].rigid


def place(edges: Sequence[PairEstimate], support: Sequence[int]) -> tuple[dict[int, np.ndarray], list[int]]:
    """Return first poses (4, 4) of all views that have edges, and the edges they go along, in order.

    These are the best supported, then most confident ones; those that leave something open only where there are no
    others. Views that edges connect are in the frame of one of them.
    """
    touching: dict[int, list[tuple[tuple[float, ...], int]]] = {}
    for k, (edge, votes) in enumerate(zip(edges, support, strict=True)):
        rank = not _is_rigid(edge), -votes, -edge.confidence, edge.source, edge.target
        for view in (edge.source, edge.target):
            touching.setdefault(view, []).append((rank, k))
    T: dict[int, np.ndarray] = {}
    tree = []
    for root in sorted(touching.keys()):
        if root in T:
            continue
        T[root], waiting = np.eye(4), sorted(touching[root])
        while waiting:
            _, k = heappop(waiting)
            source, target, T_target_source = edges[k].source, edges[k].target, edges[k].T_target_source
            if (source in T and target in T) or T_target_source is None:
                continue
            tree.append(k)
            new = source if target in T else target
            T[new] = T[target] @ T_target_source if new == source else T[source] @ poses.invert(T_target_source)
            for following in touching[new]:
                heappush(waiting, following)
    return T, tree


def count_support(edges: Sequence[PairEstimate], diameter: float, settings: GraphSettings) -> list[int]:
    """Count, for each rigid edge, the triangles of rigid edges that close with it, less those that do not."""
    rigid = [k for k, edge in enumerate(edges) if _is_rigid(edge)]
    support = np.zeros(len(edges), dtype=int)
    if not rigid:
        return support.tolist()
    forth = np.array([edges[k].T_target_source for k in rigid])
    T, back = np.concatenate([forth, invert_all(forth)]), len(rigid)
    row: dict[tuple[int, int], int] = {}  # (a, b) -> where T_a_b stands
    neighbours: dict[int, set[int]] = {}
    for at, k in enumerate(rigid):
        source, target = edges[k].source, edges[k].target
        row[target, source], row[source, target] = at, at + back
        neighbours.setdefault(source, set()).add(target)
        neighbours.setdefault(target, set()).add(source)
    triangles = [
        (at, row[edges[k].target, third], row[third, edges[k].source])
        for at, k in enumerate(rigid)
        for third in sorted(neighbours[edges[k].source] & neighbours[edges[k].target])
    ]
    if not triangles:
        return support.tolist()
    edge, leg, other = np.array(triangles).T
    D = T[leg] @ T[other] @ T[edge + back]
    centers = np.array([edges[k].center for k in rigid])[edge]
    turned = np.degrees(2 * np.arcsin(np.clip(np.linalg.norm(D[:, :3, :3] - np.eye(3), axis=(1, 2)) / 8**0.5, 0, 1)))
    shifted = np.linalg.norm(np.einsum("eij,ej->ei", D[:, :3, :3], centers) + D[:, :3, 3] - centers, axis=1)
    closes = (turned < settings.triangle_deg) & (shifted < settings.triangle_shift * diameter)
    np.add.at(support, np.array(rigid)[edge], np.where(closes, 1, -1))
    return support.tolist()


def solve(
    pairs: Sequence[PairEstimate],
    views: Sequence[int],
    diameter: float,
    settings: GraphSettings,
    before: Collection[int] = (),
) -> Solution:
    """Find the poses of views (in the order of use) that all pairs agree on best; one that contradicts is left out.

    The diameter [m] is the object's. Pairs are reweighted by how each disagrees in proportion to what is usual. Those
    that leave something open hold only what nothing else holds. Of components that of the views `before`, where there
    are any, comes first. Raises ValueError for a pair without pose or information.
    """
    edges = Measurements.of(pairs, views)
    found, tree = place(pairs, count_support(pairs, diameter, settings))
    T = np.array([found.get(view, np.eye(4)) for view in views])
    rigid = np.array([_is_rigid(pair) for pair in pairs], dtype=bool)
    used = rigid.copy()
    used[tree] = True
    fixed = np.unique(label_groups(views, _ends(pairs, used)))  # the first view of each group
    T, weights = relax(edges.take(used), T, fixed, diameter, settings.outlier, settings.iterations)
    contradicted = np.zeros(len(pairs), dtype=bool)
    contradicted[used] = (weights <= _QUARTER) & _differ(edges.take(used), T, diameter, settings)
    holding = used & ~contradicted
    ends = _ends(pairs, holding), _ends(pairs, holding & rigid)
    components = find_components(dict(zip(views, T, strict=True)), *ends, before=before)
    return Solution(components, tuple((~contradicted).tolist()))


def _differ(edges: Measurements, T: np.ndarray, diameter: float, settings: GraphSettings) -> np.ndarray:
    """Whether the poses depart from an edge (E,) by more than edges of real scans do from each other."""
    turn, shift = np.split(edges.measure_residuals(T), 2, axis=1)
    turned, shifted = np.degrees(np.linalg.norm(turn, axis=1)), np.linalg.norm(shift, axis=1)
    return (turned > settings.contradiction_deg) | (shifted > settings.contradiction_shift * diameter)


def _ends(pairs: Sequence[PairEstimate], chosen: np.ndarray) -> list[Ends]:
    """The views of the chosen pairs (E,) bool."""
    return [pair.ends for pair, take in zip(pairs, chosen, strict=True) if take]


def _is_rigid(pair: PairEstimate) -> bool:
    """Whether a pair leaves nothing open."""
    return pair.status == Status.OK
