"""The colours of a view's surface: what each surfel looks like, how that changes along the surface, and how well known.

Colours are logarithmic, so that a lamp's brightness and a camera's gain are offsets: one brightness, and two chromas,
which white light leaves as they are.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.processing.surface.lighting import TRACES, find_highlights, light_basis, remove_light
from orbitscan.processing.surface.preparation import Surface, Surfels

CHANNELS = 3
_DARK = 10.0  # of 255, added before the logarithm: what is darker is a sensor's noise
_NEAREST = 16  # points that tell a surfel's colour
_LEAST_DEVIATION = 0.015  # of a logarithm: two images of one spot differ by as much, whatever a sensor's noise
_OFF = 1.0  # multiples of w by which colours may lie beside the depths that they belong to
_PATTERN = 0.5  # mean square in variances, beyond traces of light, of a view with paint; plain ones have less
_MIXED = np.array([[1 / 3, 1 / 3, 1 / 3], [1, -1, 0], [0.5, 0.5, -1]])  # brightness and chromas, from red, green, blue
_RIDGE = 1e-3  # of the trace: points in one line tell no gradient across it


@dataclass(frozen=True, eq=False)
class Appearance:
    """What surfels look like: logarithms of brightness and two chromas (red to green, both to blue)."""

    values: np.ndarray  # (S, 3)
    gradients: np.ndarray  # (S, 3, 3) how each changes along the surface, per metre
    variances: np.ndarray  # (S, 3)
    light: np.ndarray  # (S, L) what lamps may add up of, in this view
    bright: np.ndarray  # (S,) bool: so bright that a lamp may be mirrored there

    @cached_property
    def is_patterned(self) -> bool:
        """Whether there is paint: clearly more contrast than lamps and noise leave of one colour."""
        dull = ~self.bright
        left, _ = remove_light(self.values[dull], self.variances[dull], self.light[dull])
        squares = np.maximum(np.abs(left) - TRACES, 0) ** 2 / self.variances[dull]
        return len(squares) > 0 and float(squares.mean()) > _PATTERN

    def of(self, rows: slice) -> "Appearance":
        """That of some of the surfels."""
        fields = (self.values, self.gradients, self.variances, self.light, self.bright)
        return Appearance(*(field[rows] for field in fields))


def measure_appearance(surface: Surface, w: float) -> Appearance | None:
    """Measure what each surfel looks like from the colours of the points around it; None for a view without colours.

    A plane is fitted to each colour over the surface. Its variance is that of the points about it, at least what images
    differ by, and what colours beside their depths would change: where they change fast they tell little. w in metres.
    """
    if surface.colors is None or len(surface.points) < _NEAREST:
        return None
    surfels, points = surface.surfels, surface.points.astype(np.float64)
    colors = np.log(surface.colors.astype(np.float64) + _DARK) @ _MIXED.T
    _, nearest = cKDTree(points).query(surfels.points, _NEAREST)
    offsets = np.einsum("ska,sla->slk", _tangents(surfels), points[nearest] - surfels.points[:, None]) / w
    rows = np.concatenate([np.ones((*offsets.shape[:2], 1)), offsets], axis=2)  # (S, K, 3)
    N = np.einsum("ska,skb->sab", rows, rows)
    N[:, (1, 2), (1, 2)] += _RIDGE * np.trace(N, axis1=1, axis2=2)[:, None]
    inverse = np.linalg.inv(N)
    fitted = inverse @ np.einsum("ska,skc->sac", rows, colors[nearest])  # (S, 3, channels)
    left = colors[nearest] - rows @ fitted
    scatter = (left**2).sum(axis=1) / (_NEAREST - 3)
    gradients = np.einsum("ska,skc->sca", _tangents(surfels), fitted[:, 1:]) / w
    variances = scatter * inverse[:, :1, 0] + _LEAST_DEVIATION**2 + (gradients**2).sum(axis=2) * (_OFF * w) ** 2
    light = light_basis(surfels.normals)
    return Appearance(
        fitted[:, 0], gradients, variances, light, find_highlights(fitted[:, 0, 0], variances[:, 0], light)
    )


def _tangents(surfels: Surfels) -> np.ndarray:
    """Two unit vectors (S, 2, 3) along the surface at each surfel."""
    n = surfels.normals
    flattest = np.eye(3)[np.abs(n).argmin(axis=1)]
    first = np.cross(n, flattest)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(n, first)], axis=1)
