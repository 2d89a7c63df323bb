"""Whether two views show an object at one size: one may be in other units, or by a camera calibrated otherwise."""

from typing import NamedTuple

import numpy as np

from orbitscan.processing.registration.covariance import Pulls, find_pulls, spread
from orbitscan.processing.registration.normal_equations import Problem, motion
from orbitscan.recorder import poses

_ROUNDS = 10  # of alignment, size and all
_SUSPICIOUS = 4.0  # deviations: of less, the first round is believed; further ones amplify the noise of normals
_DIFFERENT = 0.025  # share from which on views are of different size; within 2 % a depth camera measures here and there
_CERTAIN = 5.0  # deviations
_RIDGE = 1e-9  # of the trace: a motion that nothing determines stays at rest


class ScaleDifference(NamedTuple):
    """By how much the source is larger than the target, as a share of it, and the deviation of that."""

    larger: float
    deviation: float

    @property
    def significance(self) -> float:
        """How many standard deviations the difference is."""
        return abs(self.larger) / max(self.deviation, 1e-12)

    @property
    def is_certain(self) -> bool:
        """Whether the views cannot be of one size."""
        return abs(self.larger) > _DIFFERENT and self.significance > _CERTAIN

    def __str__(self) -> str:
        word = "larger" if self.larger > 0 else "smaller"
        return f"it is {100 * abs(self.larger):.1f} % {word} than the view it is registered to"


def measure_scale(problem: Problem, T_target_source: np.ndarray, patch: float) -> ScaleDifference | None:
    """Measure how much larger the source is than the target, from an aligned pose; None where too few surfels meet.

    The alignment goes on with the size as a seventh unknown. A patch [m] is what residuals are alike in.
    """
    middle = problem.points.mean(axis=0)
    T, size = T_target_source, 1.0
    found: ScaleDifference | None = None
    for _ in range(_ROUNDS):
        center = poses.transform(T, middle[None])[0]
        grown = problem._replace(points=middle + size * (problem.points - middle))
        solved = _solve(find_pulls(grown, T), center, patch)
        if solved is None:
            return None
        x, deviation = solved
        T, size = motion(x[:6], center) @ T, size * (1 + x[6])
        found = ScaleDifference(1 / size - 1, deviation / size)
        if found.significance < _SUSPICIOUS:
            break
    return found


def _solve(pulls: Pulls, center: np.ndarray, patch: float) -> tuple[np.ndarray, float] | None:
    """The turn, shift and growth (7,) about a centre (3,) that improve a pose most, and the deviation of the growth."""
    if len(pulls.places) < 7:
        return None
    arms = pulls.places - center
    reach = float(np.sqrt((arms**2).sum(axis=1).mean()))
    growth = np.einsum("ni,ni->n", arms, pulls.along)
    units = np.array([1 / reach] * 3 + [1.0] * 3 + [1 / reach])
    J = np.hstack([pulls.rows(center), growth[:, None]]) * units
    A = (J * pulls.weights[:, None]).T @ J
    inverse = np.linalg.inv(A + _RIDGE * np.trace(A) * np.eye(7))
    x = -inverse @ (J.T @ (pulls.weights * pulls.residuals))
    left = pulls.residuals + J @ x
    covariance = spread(inverse, J, pulls.weights, left, pulls.places / patch)
    return None if covariance is None else (x * units, float(np.sqrt(covariance[6, 6])) / reach)
