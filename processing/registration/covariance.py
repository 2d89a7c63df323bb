"""How well a pose is known: its covariance, from how the residuals of an alignment scatter, patch by patch.

Were residuals independent and their variances right, the inverse of the information were the covariance. Neither is so:
neighbouring surfels share points, and sensors err alike in neighbouring pixels. So what the residuals of each patch
pull at the pose is summed, and the scatter of these sums tells the covariance, whatever the noise is (the sandwich of
White, A heteroskedasticity-consistent covariance matrix estimator, 1980, for clusters).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from orbitscan.processing.registration.correspondences import find_correspondences
from orbitscan.processing.registration.normal_equations import Problem, motion, normal_equations
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.recorder import poses

_LEAST_PATCHES = 8  # that tell how patches scatter
_LEAST_INFORMATION = 1e-4  # share of the mean: less of a motion is the noise of normals
_RIDGE = 1e-12  # of the trace: of motions that nothing holds
_LARGEST_SHARE = 0.95  # of the information that one patch may hold: what more would tell is too little
_LONGEST = 4.0  # steps, in the motion that is held most weakly


class Rows(NamedTuple):
    """Linearised residuals: how each changes with a turn [rad] about a centre and a shift [m]."""

    rows: np.ndarray  # (N, 6)
    weights: np.ndarray  # (N,)
    residuals: np.ndarray  # (N,)
    places: np.ndarray  # (N, 3) in the target's frame [m]
    shared: np.ndarray  # (N, S) what S errors that all of them share add to each: a standard deviation's

    @property
    def pull(self) -> np.ndarray:
        """(6,) what they pull at the pose together, as the b of normal equations."""
        return self.rows.T @ (self.weights * self.residuals)


def measure_uncertainty(
    problem: Problem,
    T_target_source: np.ndarray,
    center: np.ndarray,
    patch: float,
    step: float,
    besides: Callable[[np.ndarray, np.ndarray], Rows] | None = None,
) -> Uncertainty | None:
    """Measure the covariance about a centre (3,) of a pose that solves a problem; None where too few surfels meet.

    How the pull changes when the pose is moved by a step [m] either way tells how firmly it is held: surfels find
    others then, so noise of normals is not taken for relief, nor what a gate cuts off for certainty. A patch [m] is
    what residuals are alike in. Besides the problem's there may be other residuals, by pose and centre.
    """
    here = find_pulls(problem, T_target_source)
    if len(here.places) < 6 * _LEAST_PATCHES:
        return None
    reach = float(np.sqrt(((here.places - center) ** 2).sum(axis=1).mean()))
    units = np.repeat([1 / reach, 1.0], 3)

    def pull(T: np.ndarray) -> np.ndarray:
        _, b = normal_equations(problem, T, center)
        return b if besides is None else b + besides(T, center).pull

    def change(direction: np.ndarray, size: float) -> np.ndarray:
        """How the pull (6,) changes along a direction (6,), per metre, within so many metres [m] either way."""
        moved = [motion(sign * size * direction * units, center) @ T_target_source for sign in (1, -1)]
        there, back = (pull(T) * units for T in moved)
        return (there - back) / (2 * size)

    M = np.stack([change(unit, step) for unit in np.eye(6)], axis=1)
    values, vectors = np.linalg.eigh((M + M.T) / 2)
    usual = max(float(np.trace(M)) / 6, 1e-300)
    for k, direction in enumerate(vectors.T):  # what is held weakly is told by longer steps only
        longer = step * min(_LONGEST, 1 / np.sqrt(max(values[k] / usual, 1e-12)))
        if longer > step:
            values[k] = direction @ change(direction, longer)
    inverse = vectors / np.maximum(values, _LEAST_INFORMATION * usual) @ vectors.T
    told, systematic = (
        [Rows(here.rows(center), here.weights, here.residuals, here.places, np.empty(0))],
        np.zeros((6, 6)),
    )
    if besides is not None:
        told.append(besides(T_target_source, center))
        off = inverse @ ((told[1].rows * units * told[1].weights[:, None]).T @ told[1].shared)
        systematic = off @ off.T
    rows, weights, residuals, places = (np.concatenate(column) for column in list(zip(*told, strict=True))[:4])
    covariance = spread(inverse, rows * units, weights, residuals, places / patch)
    return None if covariance is None else Uncertainty((covariance + systematic) * units[:, None] * units, center)


class Pulls(NamedTuple):
    """What each corresponding surfel pulls at a pose: along which direction, how strongly, and where."""

    places: np.ndarray  # (N, 3) in the target's frame
    along: np.ndarray  # (N, 3) unit
    residuals: np.ndarray  # (N,) [m]
    weights: np.ndarray  # (N,)

    def rows(self, center: np.ndarray) -> np.ndarray:
        """(N, 6) how the residuals change with a turn about the centre and with a shift."""
        return np.hstack([np.cross(self.places - center, self.along), self.along])


def find_pulls(problem: Problem, T: np.ndarray) -> Pulls:
    """Find what pulls at a pose T_target_source, as the alignment's normal equations sum it up."""
    points, normals = poses.transform(T, problem.points), poses.rotate(T, problem.normals)
    target = problem.target
    found = find_correspondences(points, normals, target, problem.gate)
    near = np.flatnonzero(found >= 0)
    at = found[near]
    offset = points[near] - target.grid.points[at]
    along = normals[near] + target.normals[at]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    residual = np.einsum("ni,ni->n", offset, along)
    kept = (offset**2).sum(axis=1) - residual**2 <= problem.slide**2
    near, at, residual, along = near[kept], at[kept], residual[kept], along[kept]
    variance = problem.variances[near] + target.variances[at]
    weight = 1.0 / (1.0 + residual**2 / (problem.cutoff_squared * variance))
    return Pulls(points[near], along, residual, weight**2 / variance)


def spread(
    inverse: np.ndarray, rows: np.ndarray, weights: np.ndarray, residuals: np.ndarray, cells: np.ndarray
) -> np.ndarray | None:
    """The covariance (k, k) of what residuals (N,) with rows (N, k) determine; None for too few.

    `inverse` is that of the information. The places (N, 3) of residuals are in units of a patch; patches twice and four
    times as wide are looked at too, and the most is believed.
    """
    pulls = rows * (weights * residuals)[:, None]
    information = (rows * weights[:, None])[:, :, None] * rows[:, None, :]
    scatters = (_scatter(cells / size, pulls, information) for size in (1, 2, 4))
    return max((inverse @ S @ inverse for S in scatters if S is not None), key=np.trace, default=None)


def _scatter(cells: np.ndarray, pulls: np.ndarray, information: np.ndarray) -> np.ndarray | None:
    """The scatter (k, k) of the sums of pulls (N, k) over patches, by places (N, 3) in units of one.

    A patch that alone holds a motion pulls at nothing where the alignment ends: what it pulled has moved the pose. Its
    sum is made larger by what it holds of the information, (N, k, k) of the residuals (the CR2 of Bell and McCaffrey,
    Bias reduction in standard errors for linear regression with multi-stage samples, 2002).
    """
    _, patch = np.unique(np.floor(cells).astype(np.int64), axis=0, return_inverse=True)
    order = np.argsort(patch.ravel(), kind="stable")
    starts = np.flatnonzero(np.diff(patch.ravel()[order], prepend=-1))
    if len(starts) < _LEAST_PATCHES:
        return None
    sums, held = (np.add.reduceat(values[order], starts) for values in (pulls, information))
    whole = held.sum(axis=0)
    L = np.linalg.cholesky(whole + _RIDGE * np.trace(whole) * np.eye(len(whole)))
    white = np.linalg.inv(L)
    share, axes = np.linalg.eigh(white @ held @ white.T)
    larger = 1 / np.sqrt(1 - np.clip(share, 0, _LARGEST_SHARE))
    sums = np.einsum("gij,gj,gkj,gk->gi", axes, larger, axes, sums @ white.T)
    return L @ (sums.T @ sums) @ L.T
