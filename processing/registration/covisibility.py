"""What both sensors must see under a pose, and how well it is explained: the grounds on which poses are compared.

A surfel tells something where it lies on the other view's surface, or where the other sensor looked through it to a
surface behind; to nothing behind only where the recording says that empty directions were looked at, for else they may
be holes. Where the other sensor saw a nearer surface it tells nothing: so overlap alone earns nothing, and two poses
are compared by how well each explains what it must.
"""

from dataclasses import dataclass

import numpy as np

from orbitscan.processing.registration.encounter import EncounterSettings, meet
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.recorder import poses

_MEDIAN = 0.4549  # of a squared standard normal deviate: what the median of squared residuals is divided by
_LEAST_SPREAD = 1.0  # of a patch's mean square, in what is usual: were all its residuals one, it were 1.4


@dataclass(frozen=True)
class CovisibilitySettings:
    """When a pose explains the views worse than another; not in the thesis."""

    most: float = 25.0  # variances, as they are or as they usually are: what is seen through, or a stray, counts so
    least: float = 0.3  # variances that are usual at least: what quadrics cannot follow differs from pose to pose
    worse: float = 5.0  # standard deviations by which a pose explains the views worse that is refuted


@dataclass(frozen=True, eq=False)
class Explanation:
    """How a pose explains what both sensors must see, by patches of neighbouring surfels.

    Neighbours' residuals are not independent, since a surfel is fitted to points that its neighbours share, and so do
    the errors of many sensors; those of patches are.
    """

    squares: np.ndarray  # (K,) squared residuals of the surfels that tell something, in variances; inf: seen through
    patches: np.ndarray  # (K,) int, which patch each of them is in
    settings: CovisibilitySettings

    @property
    def usual(self) -> float:
        """What is usual of a squared residual, in variances: how far the noise that is meets the noise assumed."""
        met = self.squares[np.isfinite(self.squares)]
        return max(float(np.median(met)) / _MEDIAN, self.settings.least) if len(met) else self.settings.least

    def worse_than(self, other: "Explanation") -> float:
        """By how many standard deviations this pose explains the views worse than another; negative if better.

        Both are measured in what is usual under the other: it is the one that is believed. Where no surfel tells
        anything, nothing is worse.
        """
        if not len(self.squares) or not len(other.squares):
            return 0.0
        usual = other.usual
        (ours, our_mean, _), (theirs, their_mean, spread) = (e._summarize(usual) for e in (self, other))
        return float((our_mean - their_mean) / (spread * np.sqrt(ours + theirs)))

    def misfit(self, usual: float) -> float:
        """The mean squared residual, in what is usual; infinite where no surfel tells anything."""
        return self._summarize(usual)[1] if len(self.squares) else np.inf

    def _summarize(self, usual: float) -> tuple[float, float, float]:
        """Return what the square of the mean's deviation is made of: one over patches; the mean; a patch's deviation.

        In what is usual. The patches count as so many equal ones as tell as much."""
        squares = np.minimum(self.squares / usual, self.settings.most * max(1.0, 1.0 / usual))
        counts = np.bincount(self.patches).astype(float)
        mean = float(squares.mean())
        departures = np.bincount(self.patches, squares) - mean * counts
        share = float((counts**2).sum() / counts.sum() ** 2)
        spread = float(np.sqrt((departures**2).sum() / (counts**2).sum()))
        return share, mean, max(spread, _LEAST_SPREAD)


def explain(
    T_target_source: np.ndarray,
    source: PreparedView,
    target: PreparedView,
    encounter: EncounterSettings,
    settings: CovisibilitySettings,
) -> Explanation:
    """Tell how a pose explains what both sensors must see, by the judged surfels of either view."""
    ours, our_patches = _look(T_target_source, source, target, encounter)
    theirs, their_patches = _look(poses.invert(T_target_source), target, source, encounter)
    _, count = source.patches
    return Explanation(np.concatenate([ours, theirs]), np.concatenate([our_patches, their_patches + count]), settings)


def _look(
    T: np.ndarray, ours: PreparedView, other: PreparedView, settings: EncounterSettings
) -> tuple[np.ndarray, np.ndarray]:
    """The squared residuals (K,) of the surfels that tell something, and their patches (K,)."""
    found = meet(T, ours.judged_surfels, other, settings)
    squares = np.full(len(found.met), np.nan)
    squares[found.met] = found.residuals**2 / found.variances
    squares[found.in_front | (found.unseen & other.surface.outline_known)] = np.inf
    tells = ~np.isnan(squares)
    return squares[tells], ours.patches[0][tells]
