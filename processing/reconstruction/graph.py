"""Joint refinement: a graph of overlapping views whose pairs are all registered, solved for all poses at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from processing.reconstruction.symmetry import release
from processing.results.records import PairEstimate
from recorder import poses


@dataclass(frozen=True)
class GraphSettings:
    """Which pairs become edges, and how the graph is solved; not in the thesis."""

    bands_deg: tuple[float, ...] = (10.0, 30.0, 50.0, 75.0)  # an edge for every view in each band of angles between
    # viewing directions: near ones are exact, far ones keep errors from adding up
    vouching: int = 2  # recorded views apart, at most, where such a pair nearly slides
    tries: int = 40  # placed views that an unplaced one is registered to, at most
    outlier: float = 5.0  # an edge that disagrees by so many times what is usual counts a quarter, and is left out ...
    contradiction_deg: float = 1.5  # ... if that is more than this angle ...
    contradiction_shift: float = 0.02  # ... or this share of the diameter
    triangle_deg: float = 3.0  # three edges that close up to this angle ...
    triangle_shift: float = 0.03  # ... and this share of the diameter vouch for each other
    iterations: int = 20
    still: float = 1e-10


@dataclass(frozen=True, eq=False)
class Solution:
    """All poses at once."""

    T_0: Mapping[int, np.ndarray]  # view -> T_0_i of the views that edges connect to the origin
    rigid: frozenset[int]  # those of them that edges without free motions connect
    kept: tuple[bool, ...]  # which edges agree with the rest


def viewing_direction(T_0_i: np.ndarray, centroid: np.ndarray, sensor_origin: np.ndarray | None) -> np.ndarray:
    """From where a view sees the object, as a unit vector in frame {0}; along its z axis where that is unknown."""
    towards = np.array([0.0, 0.0, -1.0]) if sensor_origin is None else sensor_origin - centroid
    return T_0_i[:3, :3] @ (towards / max(float(np.linalg.norm(towards)), 1e-12))


def choose_edges(
    directions: Mapping[int, np.ndarray], known: Sequence[tuple[int, int]], settings: GraphSettings
) -> list[tuple[int, int]]:
    """The (source, target) pairs worth registering besides the known ones, by the angle between viewing directions.

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


def place(
    edges: Sequence[PairEstimate], origin: int, support: Sequence[int]
) -> tuple[dict[int, np.ndarray], list[PairEstimate]]:
    """First poses T_0_i along the best supported, then most confident edges, and these edges; of all they connect.

    Edges with free motions are taken only where there are no others.
    """
    T_0, tree = {origin: np.eye(4)}, []
    ranks = [(bool(e.freedoms), -s, -e.confidence, e.source, e.target) for e, s in zip(edges, support, strict=True)]
    waiting = [edges[k] for k in sorted(range(len(edges)), key=ranks.__getitem__)]
    while True:
        for edge in waiting:
            if (edge.source in T_0) != (edge.target in T_0):
                break
        else:
            return T_0, tree
        if edge.target in T_0:
            T_0[edge.source] = T_0[edge.target] @ edge.T_target_source
        else:
            T_0[edge.target] = T_0[edge.source] @ poses.invert(edge.T_target_source)
        tree.append(edge)
        waiting.remove(edge)


def count_support(edges: Sequence[PairEstimate], diameter: float, settings: GraphSettings) -> list[int]:
    """Of each edge: how many triangles of edges without free motions close with it, less those that do not."""
    known = {}
    for edge in edges:
        if not edge.freedoms:
            known[edge.target, edge.source] = (edge.T_target_source, edge.center)
            known[edge.source, edge.target] = (poses.invert(edge.T_target_source), None)
    neighbours: dict[int, set[int]] = {}
    for a, b in known:
        neighbours.setdefault(a, set()).add(b)
    support = []
    for edge in edges:
        votes = 0
        common = neighbours.get(edge.source, set()) & neighbours.get(edge.target, set())
        for third in sorted(common) if not edge.freedoms else ():
            around = known[edge.target, third][0] @ known[third, edge.source][0]
            D = around @ poses.invert(edge.T_target_source)
            turned = np.degrees(poses.rotation_angle(D[:3, :3]))
            shifted = float(np.linalg.norm(poses.transform(D, edge.center[None])[0] - edge.center))
            closes = turned < settings.triangle_deg and shifted < settings.triangle_shift * diameter
            votes += 1 if closes else -1
        support.append(votes)
    return support


def solve(edges: Sequence[PairEstimate], origin: int, diameter: float, settings: GraphSettings) -> Solution:
    """The poses that all edges agree on best, robustly: an edge that contradicts the others is left out.

    Gauss-Newton over SE(3) with the edges' information (Lu and Milios, Globally consistent range scan alignment, 1997),
    reweighted by how each edge disagrees in proportion to what is usual. Edges with free motions hold only what nothing
    else holds.
    """
    T_0, bridges = place(edges, origin, count_support(edges, diameter, settings))
    free = {id(edge) for edge in edges if edge.freedoms} - {id(edge) for edge in bridges}
    used = [e for e in edges if e.source in T_0 and e.target in T_0 and id(e) not in free]
    informations = [_information(edge) for edge in used]
    views = [view for view in T_0 if view != origin]
    number = {view: k for k, view in enumerate(views)}
    weights = np.ones(len(used))
    for _ in range(settings.iterations if views else 0):
        residuals = [_residual(edge, T_0) for edge in used]
        disagreement = np.array([r @ A @ r for r, A in zip(residuals, informations, strict=True)])
        usual = max(float(np.median(disagreement)), 1e-12)
        weights = 1.0 / (1.0 + disagreement / (settings.outlier**2 * usual)) ** 2
        step = _step(used, informations, residuals, weights, T_0, number)
        for view, k in number.items():
            T_0[view] = _moved(T_0[view], step[6 * k : 6 * k + 6])
        if np.abs(step).max() < settings.still:
            break
    outlying = {id(edge) for edge, weight in zip(used, weights, strict=True) if weight <= 0.25}
    contradicted = {id(edge) for edge in used if id(edge) in outlying and _differs(edge, T_0, diameter, settings)}
    kept = tuple(id(edge) not in contradicted for edge in edges)
    holding = [edge for edge in used if id(edge) not in contradicted]
    connected = _connected(holding, origin)
    rigid = _connected([edge for edge in holding if not edge.freedoms], origin)
    return Solution({view: T for view, T in T_0.items() if view in connected}, frozenset(rigid), kept)


def _information(edge: PairEstimate) -> np.ndarray:
    """What an edge says (6, 6) about a turn about its centre and a shift: nothing along its free motions."""
    A = edge.information
    for freedom in edge.freedoms:
        A = release(A, edge.center, freedom)
    return A


def _residual(edge: PairEstimate, T_0: Mapping[int, np.ndarray]) -> np.ndarray:
    """(6,) how the poses depart from an edge, in the target's frame: a turn, and the shift of the edge's centre."""
    D = poses.invert(T_0[edge.target]) @ T_0[edge.source] @ poses.invert(edge.T_target_source)
    shift = poses.transform(D, edge.center[None])[0] - edge.center
    return np.concatenate([_rotation_vector(D[:3, :3]), shift])


def _differs(edge: PairEstimate, T_0: Mapping[int, np.ndarray], diameter: float, settings: GraphSettings) -> bool:
    """Whether the poses depart from an edge by more than edges of real scans do from each other."""
    residual = _residual(edge, T_0)
    turned, shifted = np.degrees(np.linalg.norm(residual[:3])), float(np.linalg.norm(residual[3:]))
    return bool(turned > settings.contradiction_deg or shifted > settings.contradiction_shift * diameter)


def _step(
    edges: Sequence[PairEstimate],
    informations: Sequence[np.ndarray],
    residuals: Sequence[np.ndarray],
    weights: np.ndarray,
    T_0: Mapping[int, np.ndarray],
    number: Mapping[int, int],
) -> np.ndarray:
    """(6 V,) the turn and shift, in frame {0}, of each view but the origin."""
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
    return splu(H + ridge * _identity(size)).solve(b)


def _identity(size: int) -> coo_matrix:
    every = np.arange(size)
    return coo_matrix((np.ones(size), (every, every)), shape=(size, size)).tocsc()


def _moved(T: np.ndarray, x: np.ndarray) -> np.ndarray:
    R = Rotation.from_rotvec(x[:3]).as_matrix()
    moved = poses.make(R, x[3:]) @ T
    return poses.make(poses.project_rotation(moved[:3, :3]), moved[:3, 3])


def _rotation_vector(R: np.ndarray) -> np.ndarray:
    return Rotation.from_matrix(R).as_rotvec()


def _cross_matrix(p: np.ndarray) -> np.ndarray:
    return np.array([[0, -p[2], p[1]], [p[2], 0, -p[0]], [-p[1], p[0], 0]])


def _connected(edges: Sequence[PairEstimate], origin: int) -> set[int]:
    """The views that edges connect to the origin, itself among them."""
    views = sorted({origin, *(v for e in edges for v in (e.source, e.target))})
    number = {view: k for k, view in enumerate(views)}
    rows = [number[e.source] for e in edges]
    columns = [number[e.target] for e in edges]
    _, labels = connected_components(coo_matrix((np.ones(len(edges)), (rows, columns)), shape=(len(views),) * 2))
    return {view for view in views if labels[number[view]] == labels[number[origin]]}
