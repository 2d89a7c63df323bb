"""How well a pose is known: its covariance, and within what the truth lies with 95 % probability."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.stats import chi2

from orbitscan.processing.results.status import WRONG_DEG, WRONG_SHARE

_CONFIDENCE = 0.95
_WHOLE_DEG = 180.0  # no turn is larger


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """The covariance of a pose."""

    covariance: np.ndarray  # (6, 6) of a turn [rad] about the centre, then a shift [m]
    center: np.ndarray  # (3,) metres

    @cached_property
    def rotation_bound_deg(self) -> float:
        """The angle within which the pose is right with 95 % probability."""
        return min(_WHOLE_DEG, float(np.degrees(bound(self.covariance[:3, :3]))))

    @cached_property
    def center_bound_m(self) -> float:
        """The distance within which the centre is right with 95 % probability."""
        return bound(self.covariance[3:, 3:])

    def about(self, center: np.ndarray) -> "Uncertainty":
        """The same about another centre (3,), in the same frame: what is turned wrongly shifts it."""
        x, y, z = center - self.center
        J = np.eye(6)
        J[3:, :3] = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]])
        return Uncertainty(J @ self.covariance @ J.T, center)

    def is_good(self, diameter: float) -> bool:
        """Whether what may be off is no more than what makes an estimate wrong; the diameter [m] is the object's."""
        return self.rotation_bound_deg <= WRONG_DEG and self.center_bound_m <= WRONG_SHARE * diameter


def bound(covariance: np.ndarray) -> float:
    """The angle [rad] or length [m] within which a turn or a shift of a covariance (3, 3) lies with 95 % probability.

    The sum of squares of three normal deviates is taken for a scaled chi-square of the same mean and variance
    (Satterthwaite, An approximate distribution of estimates of variance components, 1946).
    """
    total, squares = float(np.trace(covariance)), float((covariance * covariance.T).sum())
    return float(np.sqrt(squares / total * chi2.ppf(_CONFIDENCE, total**2 / squares))) if total > 0 else 0.0
