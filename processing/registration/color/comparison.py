"""How the colours of two views agree under a pose, once all that a lamp could do to them is taken out.

A lamp that stands still while the object turns makes colours that stay with the camera: they pull to no motion. Diffuse
light is a smooth function of the normal, in either view, and is fitted and removed; a highlight is a function of the
normal too, if a sharp one: where it predicts one view's colours from the other's, colours decide nothing.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from orbitscan.processing.kernels.blas import SingleThreaded
from orbitscan.processing.registration.correspondences import find_correspondences
from orbitscan.processing.registration.covisibility import Explanation
from orbitscan.processing.registration.pair import PairRegistration
from orbitscan.processing.surface.appearance import CHANNELS, Appearance
from orbitscan.processing.surface.lighting import TRACES, remove_light
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

_LEAST_SHARE, _FEWEST = 0.075, 60  # of the source's surfels that must meet for paint and lamps to be told apart
_LEFT = 0.5  # share of the contrast that the right pose may leave unexplained
_FAINT = 0.1  # contrast that is none, in what is usual at least
_MUCH, _NOTHING = 0.5, 0.8  # contrast in variances that no lamp makes, and the share that a wrong pose leaves of it
_SAME_NORMAL = 0.1  # between unit normals that a lamp lights alike
_LAMP_NEIGHBORS = 5


@dataclass(frozen=True, eq=False)
class Compared:
    """The colours of surfels that correspond under a pose, in the order of the source's."""

    places: np.ndarray  # (K, 3) in the target's frame
    source: np.ndarray  # (K,) int, which of the source's surfels
    slopes: np.ndarray  # (K, 3, 3) how each channel changes along the surface, per metre, in the target's frame
    residuals: np.ndarray  # (K, 3)
    variances: np.ndarray  # (K, 3)
    light: np.ndarray  # (K, L) what lamps may add up of


@dataclass(frozen=True, eq=False)
class ColorPair:
    """A pair of views with colours, to be compared under poses T_target_source (4, 4)."""

    pair: PairRegistration
    source: Appearance
    target: Appearance

    @classmethod
    def of(cls, pair: PairRegistration) -> "ColorPair | None":
        """The colours of a pair; None where one of the views has none, or the settings leave them out."""
        ours, theirs = (pair.source.appearance, pair.target.appearance) if pair.settings.color else (None, None)
        return None if ours is None or theirs is None else cls(pair, ours, theirs)

    @property
    def refuted(self) -> float:
        """Standard deviations by which a pose explains the colours worse that is refuted."""
        return self.pair.settings.covisibility.worse

    @property
    def is_patterned(self) -> bool:
        """Whether both views show paint: where one does not, colours choose no pose."""
        return self.source.is_patterned and self.target.is_patterned

    @property
    def least(self) -> float:
        """Variances that are usual at least."""
        return self.pair.settings.covisibility.least

    def has_contrast(self, T: np.ndarray, misfit: float) -> bool:
        """Whether what meets under a pose shows any contrast, and so much that a misfit is little of it."""
        contrast = self.explain_by_nothing(T).misfit(self.least)
        return contrast > _FAINT and misfit <= _LEFT * contrast

    def is_unexplained(self, T: np.ndarray, misfit: float) -> bool:
        """Whether what meets under a pose shows contrast, of which a misfit is much."""
        return _FAINT < self.explain_by_nothing(T).misfit(self.least) < misfit / _LEFT

    def accounts_for_most(self, T: np.ndarray, told: Explanation) -> bool:
        """Whether an explanation accounts for most of the contrast in what meets under a pose, be it noise."""
        left = told.misfit(1.0)
        return np.isfinite(left) and left <= _LEFT * self.explain_by_nothing(T).misfit(1.0)

    def accounts_for_contrast(self, T: np.ndarray, told: Explanation) -> bool:
        """Whether there certainly is contrast in what meets under a pose, and an explanation accounts for most."""
        certain = self.explain_by_nothing(T).worse_than(told) > self.refuted
        return certain and self.accounts_for_most(T, told)

    def contradicts(self, T: np.ndarray) -> bool:
        """Whether there is much contrast in what meets under a pose, of which it accounts for nearly nothing."""
        contrast = self.explain_by_nothing(T).misfit(1.0)
        return np.isfinite(contrast) and contrast > _MUCH and self.explain(T).misfit(1.0) > _NOTHING * contrast

    def compare(self, T: np.ndarray, coarse: bool = False) -> Compared:
        """Compare the colours of the source's judged surfels, or only the coarse ones, with the target's."""
        target, gate = self.pair.target.fine_target, self.pair.settings.refinement.fine_gate * self.pair.w
        surfels, looks = self._coarse if coarse else self._judged
        points, normals = poses.transform(T, surfels.points), poses.rotate(T, surfels.normals)
        found = find_correspondences(points, normals, target, gate)
        met = np.flatnonzero((found >= 0) & ~looks.bright)
        met = met[~self.target.bright[target.grid.order[found[met]]]]
        met = met if len(met) >= self._fewest(coarse) else met[:0]
        at = found[met]
        other = target.grid.order[at]
        offset = points[met] - target.grid.points[at]
        ours = np.einsum("ij,kcj->kci", T[:3, :3], looks.gradients[met])
        theirs = self.target.gradients[other]
        residuals = looks.values[met] - self.target.values[other] - np.einsum("kci,ki->kc", theirs, offset)
        variances = looks.variances[met] + self.target.variances[other]
        light = np.hstack([looks.light[met], self.target.light[other]])
        return Compared(points[met], met, (ours + theirs) / 2, residuals, variances, light)

    @SingleThreaded()
    def explain(self, T: np.ndarray, coarse: bool = False) -> Explanation:
        """Tell how a pose explains the colours of what both views show."""
        found = self.compare(T, coarse)
        return self._explanation(found.source, found.residuals, found.variances, found.light, coarse)

    def explain_by_lamp(self, T: np.ndarray) -> Explanation:
        """Tell how well a lamp explains the colours of what meets under a pose: the target's of the same normal."""
        surfels, looks = self._judged
        compared = self.compare(T)
        normals = surfels.normals[compared.source]
        far, at = self._by_normal.query(normals, _LAMP_NEIGHBORS, distance_upper_bound=_SAME_NORMAL)
        alike = np.isfinite(far).all(axis=1)
        met, at = compared.source[alike], at[alike]
        residuals = looks.values[met] - np.median(self.target.values[at], axis=1)
        variances = looks.variances[met] + np.median(self.target.variances[at], axis=1)
        return self._explanation(met, residuals, variances, compared.light[alike], False)

    def explain_by_nothing(self, T: np.ndarray) -> Explanation:
        """Tell how much colour there is to be explained in what meets under a pose: the source's, lamps taken out."""
        _, looks = self._judged
        compared = self.compare(T)
        met = compared.source
        return self._explanation(met, looks.values[met], looks.variances[met], compared.light, False)

    def _explanation(
        self, source: np.ndarray, residuals: np.ndarray, variances: np.ndarray, light: np.ndarray, coarse: bool
    ) -> Explanation:
        settings = self.pair.settings.covisibility
        if len(source) < self._fewest(coarse):
            return Explanation(np.empty(0), np.empty(0, np.int64), settings)
        left = np.maximum(np.abs(remove_light(residuals, variances, light)[0]) - TRACES, 0.0)
        patches = self._patches_coarse if coarse else self.pair.source.patches[0]
        return Explanation((left**2 / variances).ravel(), np.repeat(patches[source], CHANNELS), settings)

    def _fewest(self, coarse: bool) -> float:
        surfels, _ = self._coarse if coarse else self._judged
        return max(_FEWEST if coarse else 2 * _FEWEST, _LEAST_SHARE * len(surfels))

    @cached_property
    def _by_normal(self) -> cKDTree:
        return cKDTree(self.pair.target.surface.surfels.normals)

    @cached_property
    def _judged(self) -> tuple[Surfels, Appearance]:
        return self._thinned(self.pair.source.settings.judged_points)

    @cached_property
    def _coarse(self) -> tuple[Surfels, Appearance]:
        return self._thinned(self.pair.source.settings.coarse_points)

    def _thinned(self, most: int) -> tuple[Surfels, Appearance]:
        surfels = self.pair.source.surface.surfels
        return surfels.thinned(most), self.source.of(surfels.every(most))

    @cached_property
    def _patches_coarse(self) -> np.ndarray:
        cells = np.floor(self._coarse[0].points / self.pair.source.patch_size).astype(np.int64)
        return np.unique(cells, axis=0, return_inverse=True)[1].ravel()
