"""The poses that pairs agree on best: robust Gauss-Newton over SE(3), all pairs at once (Lu and Milios, 1997)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, eye
from scipy.sparse.linalg import SuperLU, splu
from scipy.spatial.transform import Rotation

from orbitscan.processing.registration.unobservable import release
from orbitscan.processing.results.estimates import PairEstimate

_NOTHING = 1e-9  # of the largest disagreement: a pair that disagrees by less tells nothing of what is usual
_RIDGE = 1e-12  # of the largest entry: holds what no pair says anything about where it is
_STILL = 1e-6  # a step that turns [rad] and shifts (share of the diameter) no view by more ends the iteration


@dataclass(frozen=True, eq=False)
class Measurements:
    """What E pairs say of the poses of V views, row by row."""

    views: int  # how many
    source: np.ndarray  # (E,) rows of views
    target: np.ndarray  # (E,)
    T_target_source: np.ndarray  # (E, 4, 4), metres
    information: np.ndarray  # (E, 6, 6) of a turn [rad] about the centre, then a shift [m], in the target's frame
    center: np.ndarray  # (E, 3), in the target's frame

    @classmethod
    def of(cls, pairs: Sequence[PairEstimate], views: Sequence[int]) -> Self:
        """Those of pairs of views, without any information along free motions.

        Raises ValueError for a pair without a pose, information or centre.
        """
        row = {view: k for k, view in enumerate(views)}
        T, A, center = [np.empty((0, 4, 4))], [np.empty((0, 6, 6))], [np.empty((0, 3))]
        for pair in pairs:
            if pair.T_target_source is None or pair.information is None or pair.center is None:
                raise ValueError(f"views {pair.source} and {pair.target}: a pair without information is no edge")
            told = pair.information
            for freedom in pair.freedoms:
                told = release(told, pair.center, freedom)
            T.append(pair.T_target_source[None])
            A.append(told[None])
            center.append(pair.center[None])
        source = np.array([row[pair.source] for pair in pairs], dtype=np.intp)
        target = np.array([row[pair.target] for pair in pairs], dtype=np.intp)
        return cls(len(views), source, target, np.concatenate(T), np.concatenate(A), np.concatenate(center))

    def take(self, chosen: np.ndarray) -> Self:
        """Those of the chosen rows (E,) bool."""
        rows = (self.source, self.target, self.T_target_source, self.information, self.center)
        return type(self)(self.views, *(row[chosen] for row in rows))

    @cached_property
    def T_source_target(self) -> np.ndarray:
        """The inverse motions (E, 4, 4)."""
        return invert_all(self.T_target_source)

    def measure_residuals(self, T_0: np.ndarray) -> np.ndarray:
        """How poses (V, 4, 4) depart from each pair (E, 6): a turn and a shift of the centre, in its target's frame."""
        D = invert_all(T_0[self.target]) @ T_0[self.source] @ self.T_source_target
        shift = np.einsum("eij,ej->ei", D[:, :3, :3], self.center) + D[:, :3, 3] - self.center
        turn = Rotation.from_matrix(D[:, :3, :3]).as_rotvec() if len(D) else np.empty((0, 3))
        return np.concatenate([turn, shift], axis=1)

    def linearize(self, T_0: np.ndarray) -> np.ndarray:
        """How each residual grows (E, 6, 6) as its source turns about frame {0}'s origin and shifts."""
        R = T_0[self.target, :3, :3]
        x, y, z = (np.einsum("eij,ej->ei", R, self.center) + T_0[self.target, :3, 3]).T
        nothing = np.zeros_like(x)
        about = np.array([[nothing, z, -y], [-z, nothing, x], [y, -x, nothing]]).transpose(2, 0, 1)
        J = np.zeros((len(R), 6, 6))
        J[:, :3, :3] = J[:, 3:, 3:] = R.transpose(0, 2, 1)
        J[:, 3:, :3] = R.transpose(0, 2, 1) @ about
        return J


def invert_all(T: np.ndarray) -> np.ndarray:
    """The inverses of motions (N, 4, 4)."""
    inverse = np.zeros_like(T)
    inverse[:, :3, :3] = T[:, :3, :3].transpose(0, 2, 1)
    inverse[:, :3, 3] = -np.einsum("eji,ej->ei", T[:, :3, :3], T[:, :3, 3])
    inverse[:, 3, 3] = 1
    return inverse


def factorize(pairs: Measurements, blocks: np.ndarray, column: np.ndarray) -> SuperLU:
    """Factorize the normal equations: blocks (E, 6, 6) of pairs, for the views whose `column` (V,) is not negative."""
    rows, columns, values = [], [], []
    for a, b, sign in (
        (pairs.source, pairs.source, 1),
        (pairs.target, pairs.target, 1),
        (pairs.source, pairs.target, -1),
        (pairs.target, pairs.source, -1),
    ):
        free = (column[a] >= 0) & (column[b] >= 0)
        i, j = np.mgrid[:6, :6]
        rows.append((6 * column[a[free], None, None] + i).ravel())
        columns.append((6 * column[b[free], None, None] + j).ravel())
        values.append(sign * blocks[free].ravel())
    size = 6 * (int(column.max()) + 1)
    entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
    H = csc_matrix(coo_matrix(entries, shape=(size, size)))
    return splu(H + _RIDGE * H.diagonal().max() * eye(size, format="csc"))


def number_free(views: int, fixed: np.ndarray) -> np.ndarray:
    """The place (V,) of each view among the unknowns; -1 for rows that stay where they are."""
    free = np.ones(views, dtype=bool)
    free[fixed] = False
    return np.where(free, np.cumsum(free) - 1, -1)


def relax(
    pairs: Measurements, T_0: np.ndarray, fixed: np.ndarray, diameter: float, outlier: float, iterations: int
) -> tuple[np.ndarray, np.ndarray]:
    """Move poses (V, 4, 4), all but those of fixed rows, to where the pairs agree best.

    Returns the poses, and how much each pair counted, 0 to 1: one that disagrees by `outlier` times what is usual
    counts a quarter. The diameter [m] is the object's.
    """
    column, weights = number_free(len(T_0), fixed), np.ones(len(pairs.source))
    moved = np.flatnonzero(column >= 0)
    for _ in range(iterations if len(moved) and len(weights) else 0):
        r, J = pairs.measure_residuals(T_0), pairs.linearize(T_0)
        disagreement = np.einsum("ei,eij,ej->e", r, pairs.information, r)
        told = disagreement[disagreement > _NOTHING * disagreement.max(initial=0.0)]  # not those first poses follow
        usual = max(float(np.median(told)) if len(told) else 0.0, 1e-12)
        weights = 1.0 / (1.0 + disagreement / (outlier**2 * usual)) ** 2
        pull = weights[:, None, None] * J.transpose(0, 2, 1) @ pairs.information
        b = np.zeros((len(T_0), 6))
        np.add.at(b, pairs.source, -np.einsum("eij,ej->ei", pull, r))
        np.add.at(b, pairs.target, np.einsum("eij,ej->ei", pull, r))
        step = factorize(pairs, pull @ J, column).solve(b[moved].ravel()).reshape(-1, 6)
        T_0 = T_0.copy()
        T_0[moved] = _move(T_0[moved], step)
        if np.abs(step / np.repeat([1.0, diameter], 3)).max() < _STILL:
            break
    return T_0, weights


def _move(T: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Move poses (N, 4, 4), each by a turn [rad] about the origin and a shift [m] (N, 6)."""
    R = Rotation.from_rotvec(step[:, :3]).as_matrix()
    moved = T.copy()
    moved[:, :3, :3] = Rotation.from_matrix(R @ T[:, :3, :3]).as_matrix()  # a rotation in spite of rounding
    moved[:, :3, 3] = np.einsum("eij,ej->ei", R, T[:, :3, 3]) + step[:, 3:]
    return moved
