"""How well the views of a graph are known: the covariances of its pairs, carried to its poses."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import coo_matrix, eye
from scipy.sparse.linalg import splu

from orbitscan.processing.reconstruction.pose_graph import Edge, measure_residual
from orbitscan.processing.registration.color.decision import COLOR
from orbitscan.processing.results.estimates import PairEstimate
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.recorder import poses


def measure_graph(
    pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray], center: np.ndarray, origin: int
) -> dict[int, Uncertainty]:
    """Measure the covariance of every pose T_0_i about a centre (3,) in frame {0}.

    All pairs have a covariance, and connect all views to the origin. What a pair is off comes from the noise of both of
    its views, half from each; that of one view is alike in all its pairs, as far as these overlap with it. Where pairs
    contradict each other by more than they say they may be off, all are taken to be off by as much more.
    """
    number = {view: k for k, view in enumerate(view for view in T_0 if view != origin)}
    size = 6 * len(number)
    if not size:
        return {}
    rows, columns, values = [], [], []
    pulls, ends = [], []
    for pair in pairs:
        J, W, root = _linearize(pair, T_0[pair.target])
        H, pull = J.T @ W @ J, J.T @ W @ root
        signed = [(number[view], sign) for view, sign in ((pair.source, 1), (pair.target, -1)) if view in number]
        for k, sign in signed:
            for m, other in signed:
                i, j = np.mgrid[6 * k : 6 * k + 6, 6 * m : 6 * m + 6]
                rows.append(i.ravel())
                columns.append(j.ravel())
                values.append((sign * other * H).ravel())
        pulls.append(pull)
        ends.append((number.get(pair.source), number.get(pair.target)))
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    H = coo_matrix(entries, shape=(size, size)).tocsc()
    factor = splu(H + 1e-12 * H.diagonal().max() * eye(size, format="csc"))
    excess = _measure_excess(pairs, T_0, 6 * (len(pairs) - len(number)))
    found = {}
    for view, k in number.items():
        unit = np.zeros((size, 6))
        unit[6 * k : 6 * k + 6] = np.eye(6)
        Z = factor.solve(unit).reshape(-1, 6, 6)  # of each view: what its pull does to this one
        effects = []
        for (source, target), pull in zip(ends, pulls, strict=True):
            effect = np.zeros((6, 6))
            for end, sign in ((source, 1), (target, -1)):
                if end is not None:
                    effect += sign * Z[end].T @ pull
            effects.append(effect)
        covariance = excess * _sum(pairs, effects)
        found[view] = Uncertainty(covariance, np.zeros(3)).about(center)
    return found


def _linearize(pair: PairEstimate, T_0_target: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How a pair departs when its source moves about frame {0}'s origin (6, 6), its information, its error's root.

    All in frame {0}, about the pair's centre."""
    if pair.center is None or pair.information is None or pair.covariance is None:
        raise ValueError(f"views {pair.source} and {pair.target}: nobody knows how well the pair is known")
    x, y, z = poses.transform(T_0_target, pair.center[None])[0]
    J = np.eye(6)
    J[3:, :3] = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
    R = np.kron(np.eye(2), T_0_target[:3, :3])
    spread, axes = np.linalg.eigh(R @ pair.covariance @ R.T)
    return J, R @ pair.information @ R.T, axes * np.sqrt(np.maximum(spread, 0.0)) @ axes.T


def _measure_excess(pairs: Sequence[PairEstimate], T_0: Mapping[int, np.ndarray], redundant: int) -> float:
    """By how many variances the poses depart from the pairs on average, at least one: the variance of unit weight.

    `redundant` is by how much there are more residuals than unknowns; without any nothing contradicts.
    """
    if redundant <= 0:
        return 1.0
    total = 0.0
    for pair in pairs:
        r = measure_residual(Edge.of(pair), T_0)
        total += float(r @ np.linalg.pinv(np.asarray(pair.covariance), hermitian=True) @ r)
    return max(1.0, total / redundant)


def _sum(pairs: Sequence[PairEstimate], effects: Sequence[np.ndarray]) -> np.ndarray:
    """The covariance (6, 6) that the errors of pairs add up to, those of one view's noise together.

    Along a chain a view's noise in the pair that leads to it cancels that in the next one; what a sensor is off the
    same way in all views does not. So where all errors for themselves add up to more, that is believed; and where those
    of pairs that colours settled do so one on top of the other: a camera puts all colours beside the surface alike.
    """
    covariance, apart = np.zeros((6, 6)), np.zeros((6, 6))
    shared: dict[int, np.ndarray] = {}
    for pair, effect in zip(pairs, effects, strict=True):
        overlap = pair.evidence.overlap or 0.0
        apart += effect @ effect.T
        covariance += (1 - overlap) * effect @ effect.T
        for view, sign in ((pair.source, 1), (pair.target, -1)):
            shared[view] = shared.get(view, np.zeros((6, 6))) + sign * np.sqrt(overlap / 2) * effect
    for together in shared.values():
        covariance += together @ together.T
    colored = sum((e for pair, e in zip(pairs, effects, strict=True) if pair.start == COLOR), np.zeros((6, 6)))
    return max(covariance, apart, colored @ colored.T, key=np.trace)
