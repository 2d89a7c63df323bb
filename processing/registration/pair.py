"""A pair of views to be registered: what both of them and the settings determine, for every step that asks."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np

from orbitscan.processing.registration import covariance, covisibility, surface_icp, unobservable, verification
from orbitscan.processing.registration.covariance import Rows
from orbitscan.processing.registration.covisibility import CovisibilitySettings, Explanation
from orbitscan.processing.registration.hypotheses import StartSettings
from orbitscan.processing.registration.matching import MatchSettings
from orbitscan.processing.registration.normal_equations import Problem
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.registration.ransac import Matches
from orbitscan.processing.registration.scale_difference import ScaleDifference, measure_scale
from orbitscan.processing.registration.surface_icp import Refined, RefinementSettings
from orbitscan.processing.registration.unobservable import Motion, SymmetrySettings
from orbitscan.processing.registration.verification import Verification, VerificationSettings
from orbitscan.processing.results.estimates import Evidence, PairEstimate
from orbitscan.processing.results.status import Status
from orbitscan.processing.results.uncertainty import Uncertainty
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

_STEP = 0.25  # multiples of w, by which a pose is moved to tell how firmly it is held


@dataclass(frozen=True)
class PairSettings:
    """How starts compete, how a pose is refined, and when it is believed."""

    starts: tuple[Literal["identity", "previous", "consensus"], ...] = ("identity", "previous", "consensus")
    # What competes: no motion, the previous step of the camera, and all that the correspondences propose.
    step_deg: float | None = None  # from one recorded view to the next, where the user knows it; see `turn_by_step`
    color: bool = True  # whether colours decide what shapes leave open
    rivals: int = 6  # poses refined on the judged surfels, at most; the winner on all
    proposals: StartSettings = field(default_factory=StartSettings)
    # Where these lead nowhere, the correspondences are looked at once more:
    thorough: StartSettings = field(default_factory=lambda: StartSettings(hypotheses=3000, worth=0.0, most=16))
    thorough_matching: MatchSettings = field(default_factory=lambda: MatchSettings(nearest=2))
    colored: StartSettings = field(default_factory=lambda: StartSettings(hypotheses=60, most=8))  # of colours' corners
    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    judgement: VerificationSettings = field(default_factory=VerificationSettings)
    covisibility: CovisibilitySettings = field(default_factory=CovisibilitySettings)
    symmetry: SymmetrySettings = field(default_factory=SymmetrySettings)


@dataclass(frozen=True, eq=False)
class PairRegistration:
    """A source and a target view, and how they are registered; poses are T_target_source (4, 4)."""

    source: PreparedView
    target: PreparedView
    settings: PairSettings

    @property
    def w(self) -> float:
        """The working resolution [m]."""
        return self.source.scale.working

    @property
    def diameter(self) -> float:
        """The object's diameter [m]."""
        return self.source.scale.diameter

    @property
    def distinct(self) -> tuple[float, float]:
        """The turn [rad] and the shift [m] from which on two poses count as distinct."""
        belief = self.settings.judgement
        return np.radians(belief.distinct_deg), belief.distinct_shift * self.diameter

    @property
    def is_colored(self) -> bool:
        """Whether both views have colours that may decide."""
        return self.settings.color and all(v.surface.colors is not None for v in (self.source, self.target))

    def center(self, T: np.ndarray) -> np.ndarray:
        """The source's centre (3,) under a pose, in the target's frame."""
        return poses.transform(T, self.source.middle[None])[0]

    def align_coarsely(self, starts: np.ndarray, gate: float, deviation: float) -> np.ndarray:
        """Align the coarse surfels from each start (B, 4, 4) to (B, 4, 4); gate and deviation are in multiples of w."""
        how = self.settings.refinement
        target, still = self.target.coarse_target, how.coarse_still * self.diameter
        return surface_icp.align_coarsely(
            self.source.coarse_surfels, target, starts, gate * self.w, deviation * self.w, how.coarse_iterations, still
        )

    def align(self, start: np.ndarray) -> Refined:
        """Align all surfels from a start."""
        return self._align(self.source.surface.surfels, start)

    def align_judged(self, start: np.ndarray) -> Refined:
        """Align the judged surfels from a start: what is judged by them needs no more."""
        return self._align(self.source.judged_surfels, start)

    def verify(self, T: np.ndarray, coarse: bool = False) -> Verification:
        """Measure how far the views agree under a pose, by their judged surfels or only the coarse ones."""
        return verification.verify(T, self.source, self.target, self.settings.judgement, coarse)

    def explain(self, T: np.ndarray) -> Explanation:
        """Tell how a pose explains what both sensors must see."""
        how = self.settings
        return covisibility.explain(T, self.source, self.target, how.judgement.encounter, how.covisibility)

    @cached_property
    def problem(self) -> Problem:
        """What brings the judged surfels together with the target."""
        how = self.settings.refinement
        return surface_icp.fine_problem(self.source.judged_surfels, self.target.fine_target, self.w, how)

    def measure_uncertainty(
        self, refined: Refined, besides: Callable[[np.ndarray, np.ndarray], Rows] | None = None
    ) -> Uncertainty | None:
        """Measure how well an aligned pose is known, where there are other residuals `besides` also by these.

        None where the views hardly meet.
        """
        if refined.center is None:
            return None
        T, patch, step = refined.T_target_source, self.source.patch_size, _STEP * self.w
        return covariance.measure_uncertainty(self.problem, T, refined.center, patch, step, besides)

    def measure_scale(self, T: np.ndarray) -> ScaleDifference | None:
        """Measure how much larger the source is than the target, from an aligned pose; None where they hardly meet."""
        return measure_scale(self.problem, T, self.source.patch_size)

    def distance(self, T_a: np.ndarray, T_b: np.ndarray) -> float:
        """Measure how different two poses are: 1 where they just count as distinct."""
        return verification.distance(T_a, T_b, self.source, self.settings.judgement)

    def find_motions(self, T: np.ndarray, coarse: bool = False) -> list[Motion]:
        """Find the motions of the source under a pose, the least determined first; none where the views hardly meet."""
        surfels = self.source.coarse_surfels if coarse else self.source.judged_surfels
        return unobservable.find_motions(
            T, surfels, self.target.fine_target, self.settings.judgement.encounter.gate * self.w
        )

    def nearly_slides(self, found: list[Motion]) -> bool:
        """Whether the least determined of the motions is hardly determined."""
        return bool(found) and found[0].information < self.settings.symmetry.suspicious

    def feature_evidence(self, matches: Matches) -> Evidence:
        """Gather what the keypoints and their matches say."""
        found = len(matches.indices)
        inliers = 0 if matches.consensus is None else int(matches.consensus.inlier.sum())
        return Evidence(
            points=len(self.source.surface.working),
            keypoints=len(self.source.keypoints),
            valid_frames=int(np.isfinite(self.source.descriptors[:, 0]).sum()),
            matches=found,
            inliers=inliers,
            inlier_ratio=inliers / found if found else 0.0,
        )

    def gather_evidence(
        self, refined: Refined, found: Verification, motions: Sequence[Motion], features: Evidence | None
    ) -> Evidence:
        """Gather what speaks for a pose; `motions` come least determined first, `features` is what the matches say."""
        met = found.overlap > 0
        return replace(
            features or Evidence(),
            points=len(self.source.surface.working),
            converged=refined.converged,
            rmse_m=found.rmse if met else None,
            overlap=found.overlap,
            misfit=found.misfit if met else None,
            violations=found.violations if met else None,
            unseen=found.unseen if met else None,
            observability=motions[0].information if motions else None,
        )

    def _align(self, surfels: Surfels, start: np.ndarray) -> Refined:
        coarse, target = self.source.coarse_surfels, self.target.fine_target
        return surface_icp.align(surfels, coarse, target, start, self.w, self.diameter, self.settings.refinement)

    def give_up(self, matches: Matches) -> PairEstimate:
        """Return an estimate without a pose, whose status says why there is no consensus."""
        status = Status.TOO_FEW_MATCHES if len(matches.indices) < 3 else Status.NO_CONSENSUS
        if min(len(self.source.keypoints), len(self.target.keypoints)) < 3:
            status = Status.TOO_FEW_KEYPOINTS
        return PairEstimate(self.source.view, self.target.view, None, status, 0.0, self.feature_evidence(matches))
