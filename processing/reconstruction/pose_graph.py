"""Joint refinement: a graph of overlapping views whose pairs are all registered, solved for all poses at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy.sparse import coo_matrix, eye
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.unobservable import release
from orbitscan.processing.results.estimates import Freedom, PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses

_NOTHING = 1e-9  # of the largest disagreement: an edge that disagrees by less tells nothing of what is usual
_QUARTER = 0.25  # the weight of an edge that disagrees as `GraphSettings.outlier` says


@dataclass(frozen=True)
class GraphSettings:
    """Which pairs become edges, and how the graph is solved; not in the thesis."""

    # An edge for every view in each band of angles between viewing directions, from 0 on: near ones are exact, far
    # ones keep errors from adding up.
    bands_deg: tuple[float, ...] = (10.0, 30.0, 50.0, 75.0)

    # A view that nothing connects is registered to placed ones.
    tries: int = 40  # at most, the nearest in time first
    open_tries: int = 4  # of them that may leave something open: then the view itself does
    vouching: int = 2  # recorded views apart, at most, where the two nearly slide: only a neighbour vouches for those

    # Three edges that close up to this vouch for each other: first poses go along the best vouched for.
    triangle_deg: float = 3.0
    triangle_shift: float = 0.03  # share of the diameter

    # An edge is left out that disagrees with the others in proportion and in absolute terms.
    outlier: float = 5.0  # times what is usual, in standard deviations: such an edge counts a quarter
    contradiction_deg: float = 1.5  # and it is off by more than this angle ...
    contradiction_shift: float = 0.02  # ... or this share of the diameter

    iterations: int = 20
    still: float = 1e-10  # a step that turns [rad] and shifts [m] no view by more ends the iteration

    # Free motions of two edges are one whose axes are so near to each other.
    same_axis_deg: float = 10.0
    same_axis_shift: float = 0.1  # share of the diameter


@dataclass(frozen=True, eq=False)
class Edge:
    """What a pair says of the poses of its views."""

    source: int  # recorded indices
    target: int
    T_target_source: np.ndarray  # (4, 4), metres
    information: np.ndarray  # (6, 6), see `PairEstimate`
    center: np.ndarray  # (3,)
    freedoms: tuple[Freedom, ...]
    confidence: float
    rigid: bool  # whether nothing is left open

    @classmethod
    def of(cls, pair: PairEstimate) -> Self:
        """The edge of a pair; raises ValueError where it has no pose or no information."""
        T, information, center = pair.T_target_source, pair.information, pair.center
        if T is None or information is None or center is None:
            raise ValueError(f"views {pair.source} and {pair.target}: a pair without information is no edge")
        rigid = pair.status == Status.OK
        return cls(pair.source, pair.target, T, information, center, pair.freedoms, pair.confidence, rigid)


@dataclass(frozen=True, eq=False)
class Solution:
    """All poses at once."""

    T_0: Mapping[int, np.ndarray]  # view -> T_0_i of the views that edges connect to the origin
    rigid: frozenset[int]  # those of them that edges connect which leave nothing open
    kept: tuple[bool, ...]  # of each edge: whether nothing contradicts it


def viewing_direction(T_0_i: np.ndarray, centroid: np.ndarray, sensor_origin: np.ndarray | None) -> np.ndarray:
    """Return the unit vector in frame {0} from the object towards a view's sensor; along -z where that is unknown."""
    towards = np.array([0.0, 0.0, -1.0]) if sensor_origin is None else sensor_origin - centroid
    return T_0_i[:3, :3] @ (towards / max(float(np.linalg.norm(towards)), 1e-12))


def choose_edges(
    directions: Mapping[int, np.ndarray], known: Sequence[tuple[int, int]], settings: GraphSettings
) -> list[tuple[int, int]]:
    """Choose the (source, target) pairs worth registering besides the known ones, by the angle of viewing directions.

    Each view gets the earlier view nearest to the middle of each band; and where the views go round, one more on its
    other side.
    """
    views = list(directions)
    D = np.array([directions[view] for view in views])
    taken = {frozenset(pair) for pair in known}
    chosen = []
    for i in range(1, len(views)):
        angles = np.degrees(np.arccos(np.clip(D[:i] @ D[i], -1, 1)))
        for low, high in zip((0.0, *settings.bands_deg), settings.bands_deg, strict=False):
            inside = np.flatnonzero((angles > low) & (angles <= high))
            if not len(inside):
                continue
            ranked = inside[np.argsort(np.abs(angles[inside] - (low + high) / 2), kind="stable")]
            first = int(ranked[0])
            between = np.degrees(np.arccos(np.clip(D[ranked] @ D[first], -1, 1)))
            beyond = ranked[between > angles[first]]
            for j in [first, *map(int, beyond[:1])]:
                if (pair := frozenset((views[i], views[j]))) not in taken:
                    taken.add(pair)
                    chosen.append((views[i], views[j]))
    return chosen


def place(edges: Sequence[Edge], origin: int, support: Sequence[int]) -> tuple[dict[int, np.ndarray], list[int]]:
    """Return first poses T_0_i of all views that edges connect to the origin, and the edges they go along, in order.

    These are the best supported, then most confident ones; those that leave something open only where there are no
    others.
    """
    T_0, tree = {origin: np.eye(4)}, []
    ranks = [(not e.rigid, -s, -e.confidence, e.source, e.target) for e, s in zip(edges, support, strict=True)]
    waiting = sorted(range(len(edges)), key=ranks.__getitem__)
    while (at := next((k for k in waiting if (edges[k].source in T_0) != (edges[k].target in T_0)), None)) is not None:
        edge = edges[at]
        if edge.target in T_0:
            T_0[edge.source] = T_0[edge.target] @ edge.T_target_source
        else:
            T_0[edge.target] = T_0[edge.source] @ poses.invert(edge.T_target_source)
        tree.append(at)
        waiting.remove(at)
    return T_0, tree


def count_support(edges: Sequence[Edge], diameter: float, settings: GraphSettings) -> list[int]:
    """Count, for each rigid edge, the triangles of rigid edges that close with it, less those that do not."""
    known = {}
    for edge in edges:
        if edge.rigid:
            known[edge.target, edge.source] = edge.T_target_source
            known[edge.source, edge.target] = poses.invert(edge.T_target_source)
    neighbours: dict[int, set[int]] = {}
    for a, b in known:
        neighbours.setdefault(a, set()).add(b)
    support = []
    for edge in edges:
        votes = 0
        common = neighbours.get(edge.source, set()) & neighbours.get(edge.target, set())
        for third in sorted(common) if edge.rigid else ():
            around = known[edge.target, third] @ known[third, edge.source]
            D = around @ poses.invert(edge.T_target_source)
            turned = np.degrees(poses.rotation_angle(D[:3, :3]))
            shifted = float(np.linalg.norm(poses.transform(D, edge.center[None])[0] - edge.center))
            closes = turned < settings.triangle_deg and shifted < settings.triangle_shift * diameter
            votes += 1 if closes else -1
        support.append(votes)
    return support


def solve(pairs: Sequence[PairEstimate], origin: int, diameter: float, settings: GraphSettings) -> Solution:
    """Find the poses that all pairs agree on best, robustly: an edge that contradicts the others is left out.

    The diameter [m] is the object's. Gauss-Newton over SE(3) with the edges' information (Lu and Milios, Globally
    consistent range scan alignment, 1997), reweighted by how each edge disagrees in proportion to what is usual. Edges
    that leave something open hold only what nothing else holds. Raises ValueError for a pair without pose or
    information.
    """
    edges = [Edge.of(pair) for pair in pairs]
    T_0, tree = place(edges, origin, count_support(edges, diameter, settings))
    used = [k for k, e in enumerate(edges) if e.source in T_0 and e.target in T_0 and (e.rigid or k in tree)]
    weights = _relax(T_0, [edges[k] for k in used], origin, settings)
    contradicted = {
        k
        for k, weight in zip(used, weights, strict=True)
        if weight <= _QUARTER and _differs(edges[k], T_0, diameter, settings)
    }
    holding = [edges[k] for k in used if k not in contradicted]
    connected = _find_connected(holding, origin)
    rigid = _find_connected([edge for edge in holding if edge.rigid], origin)
    kept = tuple(k not in contradicted for k in range(len(edges)))
    return Solution({view: T for view, T in T_0.items() if view in connected}, frozenset(rigid), kept)


def _relax(T_0: dict[int, np.ndarray], edges: Sequence[Edge], origin: int, settings: GraphSettings) -> np.ndarray:
    """Move the poses T_0_i, all but the origin's, to where the edges agree best.

    Returns how much each edge counted, 0 to 1."""
    informations = [_information(edge) for edge in edges]
    number = {view: k for k, view in enumerate(view for view in T_0 if view != origin)}
    weights = np.ones(len(edges))
    for _ in range(settings.iterations if number else 0):
        residuals = [measure_residual(edge, T_0) for edge in edges]
        disagreement = np.array([r @ A @ r for r, A in zip(residuals, informations, strict=True)])
        told = disagreement[disagreement > _NOTHING * disagreement.max(initial=0.0)]  # not those the first poses follow
        usual = max(float(np.median(told)) if len(told) else 0.0, 1e-12)
        weights = 1.0 / (1.0 + disagreement / (settings.outlier**2 * usual)) ** 2
        step = _step(edges, informations, residuals, weights, T_0, number)
        for view, k in number.items():
            T_0[view] = _move(T_0[view], step[6 * k : 6 * k + 6])
        if np.abs(step).max() < settings.still:
            break
    return weights


def _information(edge: Edge) -> np.ndarray:
    """An edge's information (6, 6) about a turn about its centre and a shift, without any along its free motions."""
    A = edge.information
    for freedom in edge.freedoms:
        A = release(A, edge.center, freedom)
    return A


def measure_residual(edge: Edge, T_0: Mapping[int, np.ndarray]) -> np.ndarray:
    """How the poses depart from an edge (6,), in the target's frame: a turn, and the shift of the edge's centre."""
    D = poses.invert(T_0[edge.target]) @ T_0[edge.source] @ poses.invert(edge.T_target_source)
    shift = poses.transform(D, edge.center[None])[0] - edge.center
    return np.concatenate([Rotation.from_matrix(D[:3, :3]).as_rotvec(), shift])


def _differs(edge: Edge, T_0: Mapping[int, np.ndarray], diameter: float, settings: GraphSettings) -> bool:
    """Whether the poses depart from an edge by more than edges of real scans do from each other."""
    residual = measure_residual(edge, T_0)
    turned, shifted = np.degrees(np.linalg.norm(residual[:3])), float(np.linalg.norm(residual[3:]))
    return bool(turned > settings.contradiction_deg or shifted > settings.contradiction_shift * diameter)


def _step(
    edges: Sequence[Edge],
    informations: Sequence[np.ndarray],
    residuals: Sequence[np.ndarray],
    weights: np.ndarray,
    T_0: Mapping[int, np.ndarray],
    number: Mapping[int, int],
) -> np.ndarray:
    """The turn [rad] and shift [m] (6 V,), in frame {0}, that bring each view but the origin nearer to the edges."""
    size = 6 * len(number)
    rows, columns, values = [], [], []
    b = np.zeros(size)
    for edge, A, r, weight in zip(edges, informations, residuals, weights, strict=True):
        R = T_0[edge.target][:3, :3].T
        p = poses.transform(T_0[edge.target], edge.center[None])[0]
        J = np.zeros((6, 6))
        J[:3, :3] = J[3:, 3:] = R
        J[3:, :3] = -R @ _cross_matrix(p)
        H, g = weight * J.T @ A @ J, weight * J.T @ A @ r
        ends = [(number[view], sign) for view, sign in ((edge.source, 1), (edge.target, -1)) if view in number]
        for k, sign in ends:
            b[6 * k : 6 * k + 6] -= sign * g
            for m, other in ends:
                i, j = np.mgrid[6 * k : 6 * k + 6, 6 * m : 6 * m + 6]
                rows.append(i.ravel())
                columns.append(j.ravel())
                values.append((sign * other * H).ravel())
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    H = coo_matrix(entries, shape=(size, size)).tocsc()
    ridge = 1e-12 * H.diagonal().max()  # holds what no edge says anything about where it is
    return splu(H + ridge * eye(size, format="csc")).solve(b)


def _move(T: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Move a pose by x (6,), a turn [rad] about the origin and a shift [m]."""
    R = Rotation.from_rotvec(x[:3]).as_matrix()
    moved = poses.make(R, x[3:]) @ T
    return poses.make(poses.project_rotation(moved[:3, :3]), moved[:3, 3])


def _cross_matrix(p: np.ndarray) -> np.ndarray:
    return np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])


def _find_connected(edges: Sequence[Edge], origin: int) -> set[int]:
    """Find the views that edges connect to the origin, itself among them."""
    views = sorted({origin, *(v for e in edges for v in (e.source, e.target))})
    number = {view: k for k, view in enumerate(views)}
    rows = [number[e.source] for e in edges]
    columns = [number[e.target] for e in edges]
    _, labels = connected_components(coo_matrix((np.ones(len(edges)), (rows, columns)), shape=(len(views),) * 2))
    return {view for view in views if labels[number[view]] == labels[number[origin]]}
