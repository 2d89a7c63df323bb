"""One pair of views, source to target, by each method of the thesis and by ours."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from processing.reconstruction import judgement, refinement
from processing.reconstruction.judgement import Judgement, JudgementSettings
from processing.reconstruction.ransac import Consensus
from processing.reconstruction.refinement import Refined, RefinementSettings, SearchableCloud
from processing.results.records import Candidate, Evidence, PairEstimate
from processing.surface import Scale, Surface


@dataclass(frozen=True)
class PairSettings:
    """How a pose is refined, and when it is believed."""

    refinement: RefinementSettings = field(default_factory=RefinementSettings)
    judgement: JudgementSettings = field(default_factory=JudgementSettings)


@dataclass(frozen=True, eq=False)
class Prepared:
    """A view with everything registration asks of it; search structures are built when a method first needs them."""

    surface: Surface
    keypoints: np.ndarray  # (K, 3)
    descriptors: np.ndarray  # (K, 352), NaN rows where the local frame is not valid
    settings: RefinementSettings

    @cached_property
    def tree(self) -> cKDTree:
        """Of the working points."""
        return cKDTree(self.surface.working)

    @property
    def few(self) -> slice:
        """Which working points stand for all of them while starts compete."""
        return slice(None, None, max(1, len(self.surface.working) // self.settings.coarse_points))

    @cached_property
    def coarse(self) -> SearchableCloud:
        """Of the few."""
        return refinement.make_searchable(self.surface.working[self.few], self.settings.neighbours)

    @cached_property
    def fine(self) -> SearchableCloud:
        """All points."""
        return refinement.make_searchable(self.surface.points, self.settings.neighbours)


def register_icp(source: Prepared, target: Prepared, scale: Scale, settings: PairSettings) -> PairEstimate:
    """The thesis's baseline (5.2): point-to-point ICP from the identity."""
    return _point_to_point(np.eye(4), source, target, scale, settings, {})


def register_consensus(
    source: Prepared,
    target: Prepared,
    matches: int,
    consensus: Consensus | None,
    scale: Scale,
    settings: PairSettings,
) -> PairEstimate:
    """The thesis's method (4.2-4.3): the same ICP from the consensus set's pose; no estimate without one."""
    features = _feature_evidence(source, matches, consensus)
    if consensus is None:
        return _no_estimate(source, target, _why_no_consensus(source, target, matches), features)
    return _point_to_point(consensus.T_target_source, source, target, scale, settings, features)


def register_competing(
    source: Prepared,
    target: Prepared,
    matches: int,
    consensus: Consensus | None,
    scale: Scale,
    settings: PairSettings,
) -> PairEstimate:
    """Ours: starts are refined coarsely by generalised ICP, geometry chooses, the winner is refined on all points."""
    starts = {"identity": np.eye(4)}
    if consensus is not None:
        starts["consensus"] = consensus.T_target_source
    w, how, belief = scale.working, settings.refinement, settings.judgement
    trials = []
    for start, T in starts.items():
        refined = refinement.generalized_icp(
            source.coarse, target.fine, T, how.coarse_gate * w, how.coarse_iterations, how.coarse_still
        )
        found = _judge(refined.T_target_source, source, target, scale, settings, source.few)
        trials.append((start, refined, found))
    trials.sort(key=lambda trial: -trial[2].score)
    finals: list[tuple[Refined, Judgement]] = []
    for _, refined, found in trials:
        if any(not _distinct(refined, other, source, scale, belief) for other, _ in finals):
            continue  # ends where a better start ended
        if finals and found.score < belief.rival_score * trials[0][2].score:
            break
        if found.score >= belief.min_score:  # where surfaces hardly meet there is nothing to refine on
            refined = refinement.generalized_icp(
                source.fine,
                target.fine,
                refined.T_target_source,
                how.fine_gate * w,
                how.fine_iterations,
                how.fine_still,
            )
        finals.append((refined, _judge(refined.T_target_source, source, target, scale, settings)))
    finals.sort(key=lambda final: -final[1].score)
    best, found = finals[0]
    rival = max((j.score for r, j in finals[1:] if _distinct(r, best, source, scale, belief)), default=0.0)
    status = judgement.status_of(found, scale, belief)
    if status == "ok" and rival > belief.ambiguous_score * found.score:
        status = "ambiguous"
    return PairEstimate(
        source.surface.view,
        target.surface.view,
        best.T_target_source,
        status,
        judgement.confidence(found, rival),
        _evidence(source, best, found, _feature_evidence(source, matches, consensus)),
        tuple(
            Candidate(start, judgement.status_of(judged, scale, belief), judged.score) for start, _, judged in trials
        ),
    )


def _point_to_point(
    start: np.ndarray,
    source: Prepared,
    target: Prepared,
    scale: Scale,
    settings: PairSettings,
    features: dict[str, float | int],
) -> PairEstimate:
    w, how = scale.working, settings.refinement
    refined = refinement.icp(
        source.surface.working, target.tree, start, how.icp_gate * w, how.icp_iterations, how.icp_still * scale.diameter
    )
    found = _judge(refined.T_target_source, source, target, scale, settings)
    return PairEstimate(
        source.surface.view,
        target.surface.view,
        refined.T_target_source,
        judgement.status_of(found, scale, settings.judgement),
        judgement.confidence(found, 0.0),
        _evidence(source, refined, found, features),
    )


def _judge(
    T: np.ndarray,
    source: Prepared,
    target: Prepared,
    scale: Scale,
    settings: PairSettings,
    chosen: slice = slice(None),
) -> Judgement:
    return judgement.judge(T, source.surface, target.surface, target.tree, scale, settings.judgement, chosen)


def _distinct(a: Refined, b: Refined, source: Prepared, scale: Scale, settings: JudgementSettings) -> bool:
    center = source.surface.working.mean(axis=0)
    return judgement.distinct(a.T_target_source, b.T_target_source, center, scale, settings)


def _feature_evidence(source: Prepared, matches: int, consensus: Consensus | None) -> dict[str, float | int]:
    inliers = 0 if consensus is None else int(consensus.inlier.sum())
    return {
        "keypoints": len(source.keypoints),
        "valid_frames": int(np.isfinite(source.descriptors[:, 0]).sum()),
        "matches": matches,
        "inliers": inliers,
        "inlier_ratio": inliers / matches if matches else 0.0,
    }


def _evidence(source: Prepared, refined: Refined, found: Judgement, features: dict[str, float | int]) -> Evidence:
    return Evidence(
        points=len(source.surface.working),
        converged=refined.converged,
        rmse_m=found.rmse if found.overlap > 0 else None,
        overlap=found.overlap,
        observability=found.observability,
        **features,
    )


def _why_no_consensus(source: Prepared, target: Prepared, matches: int) -> str:
    if min(len(source.keypoints), len(target.keypoints)) < 3:
        return "too_few_keypoints"
    return "too_few_matches" if matches < 3 else "no_consensus"


def _no_estimate(source: Prepared, target: Prepared, status: str, features: dict[str, float | int]) -> PairEstimate:
    evidence = Evidence(points=len(source.surface.working), **features)
    return PairEstimate(source.surface.view, target.surface.view, None, status, 0.0, evidence)
