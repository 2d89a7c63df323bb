"""How well the views of a graph are known: the covariances of its pairs, carried to its poses."""

from collections.abc import Mapping, Sequence

import numpy as np

from orbitscan.processing.reconstruction.graph_solver import Measurements, factorize, number_free
from orbitscan.processing.registration.color.decision import COLOR
from orbitscan.processing.results.estimates import PairEstimate
from orbitscan.processing.results.uncertainty import Uncertainty


def measure_graph(
    pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray], center: np.ndarray, origin: int
) -> dict[int, Uncertainty]:
    """Measure the covariance of every pose T_0_i about a centre (3,) in frame {0}.

    All pairs have a covariance, and connect all views to the origin. What a pair is off comes from the noise of both of
    its views, half from each; that of one view is alike in all its pairs, as far as these overlap with it. Where pairs
    contradict each other by more than they say they may be off, all are taken to be off by as much more.
    """
    views = list(T_0)
    edges, covariances = Measurements.of(pairs, views), _gather_covariances(pairs)
    if len(views) < 2:
        return {}
    T, column = np.array([T_0[view] for view in views]), number_free(len(views), np.array([views.index(origin)]))
    J, R = edges.linearize(T), np.kron(np.eye(2), T[edges.target, :3, :3])
    whole = np.array([pair.information for pair in pairs])
    factor = factorize(edges, J.transpose(0, 2, 1) @ whole @ J, column)
    pulls = J.transpose(0, 2, 1) @ whole @ _root(covariances) @ R.transpose(0, 2, 1)  # errors are shared in frame {0}
    overlap = np.array([pair.evidence.overlap or 0.0 for pair in pairs])
    colored = np.array([pair.start == COLOR for pair in pairs], dtype=float)
    excess = _measure_excess(edges, covariances, T, 6 * (len(pairs) - len(views) + 1))
    found = {}
    for view, k in zip(views, column, strict=True):
        if k < 0:
            continue
        unit = np.zeros((6 * (len(views) - 1), 6))
        unit[6 * k : 6 * k + 6] = np.eye(6)
        Z = np.zeros((len(views), 6, 6))  # of each view: what its pull does to this one
        Z[column >= 0] = factor.solve(unit).reshape(-1, 6, 6)
        effects = (Z[edges.source] - Z[edges.target]).transpose(0, 2, 1) @ pulls
        covariance = excess * _sum(edges, effects, overlap, colored)
        found[view] = Uncertainty(covariance, np.zeros(3)).about(center)
    return found


def _gather_covariances(pairs: Sequence[PairEstimate]) -> np.ndarray:
    """Those of the pairs (E, 6, 6)."""
    for pair in pairs:
        if pair.covariance is None:
            raise ValueError(f"views {pair.source} and {pair.target}: nobody knows how well the pair is known")
    return np.array([pair.covariance for pair in pairs]).reshape(-1, 6, 6)


def _root(covariances: np.ndarray) -> np.ndarray:
    """Their symmetric roots (E, 6, 6)."""
    spread, axes = np.linalg.eigh(covariances)
    return axes * np.sqrt(np.maximum(spread, 0.0))[:, None, :] @ axes.transpose(0, 2, 1)


def _measure_excess(edges: Measurements, covariances: np.ndarray, T_0: np.ndarray, redundant: int) -> float:
    """By how many variances the poses depart from the pairs on average, at least one: the variance of unit weight.

    `redundant` is by how much there are more residuals than unknowns; without any nothing contradicts.
    """
    if redundant <= 0:
        return 1.0
    r = edges.measure_residuals(T_0)
    return max(1.0, float(np.einsum("ei,eij,ej->", r, np.linalg.pinv(covariances, hermitian=True), r)) / redundant)


def _sum(edges: Measurements, effects: np.ndarray, overlap: np.ndarray, colored: np.ndarray) -> np.ndarray:
    """The covariance (6, 6) that the errors of pairs (E, 6, 6) add up to, those of one view's noise together.

    Along a chain a view's noise in the pair that leads to it cancels that in the next one; what a sensor is off the
    same way in all views does not. So where all errors for themselves add up to more, that is believed; and where those
    of pairs that colours settled (1, else 0) do so one on top of the other: a camera puts all colours beside the
    surface alike.
    """
    apart = np.einsum("eij,ekj->ik", effects, effects)
    shared = np.zeros((edges.views, 6, 6))
    halves = np.sqrt(overlap / 2)[:, None, None] * effects
    np.add.at(shared, edges.source, halves)
    np.add.at(shared, edges.target, -halves)
    together = np.einsum("e,eij,ekj->ik", 1 - overlap, effects, effects) + np.einsum("vij,vkj->ik", shared, shared)
    on_top = np.einsum("e,eij->ij", colored, effects)
    return max(together, apart, on_top @ on_top.T, key=np.trace)
