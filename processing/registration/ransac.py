"""Adaptive RANSAC over keypoint correspondences (thesis algorithms 1 and 2, with the corrections noted there)."""

from dataclasses import dataclass

import numpy as np

from orbitscan.recorder import poses
from orbitscan.recorder.kernels import kernel, over_slices


@dataclass(frozen=True)
class RansacSettings:
    """Trials and tolerance; the thesis gives the confidence and the sample of 3."""

    confidence: float = 0.99  # thesis 4.2
    tolerance: float = 2.5  # multiples of the working resolution; not in the thesis
    max_trials: int = 50_000  # not in the thesis
    batch: int = 500  # trials evaluated together
    min_inliers: int = 6  # fewer support any pose; not in the thesis


@dataclass(frozen=True, eq=False)
class Consensus:
    """The pose most correspondences agree on, refitted on all of them."""

    T_target_source: np.ndarray  # (4, 4), metres
    inlier: np.ndarray  # (M,) bool
    trials: int


@dataclass(frozen=True, eq=False)
class Matches:
    """Corresponding keypoints of a pair, and the pose most of them agree on."""

    indices: np.ndarray  # (M, 2) of keypoints, source and target
    consensus: Consensus | None


def estimate_pose(
    source: np.ndarray, target: np.ndarray, tolerance: float, settings: RansacSettings, rng: np.random.Generator
) -> Consensus | None:
    """Estimate the pose that matched points (M, 3) and (M, 3) agree on; None where fewer than `min_inliers` do.

    Trials go on until N = log(1 - confidence) / log(1 - e^3), e being the best inlier ratio so far, or the cap. A
    sample whose sides differ by more than the tolerance [m] allows is a trial that fails at once.
    """
    source = np.ascontiguousarray(source, dtype=np.float64)
    target = np.ascontiguousarray(target, dtype=np.float64)
    if len(source) < max(3, settings.min_inliers):
        return None
    best_count, best_pose, trials, needed = 0, None, 0, float(settings.max_trials)
    while trials < min(needed, settings.max_trials):
        sample = rng.integers(len(source), size=(settings.batch, 3))
        sample = sample[_same_shape(source[sample], target[sample], tolerance)]
        trials += settings.batch
        if not len(sample):
            continue
        hypotheses = fit(source[sample], target[sample])
        counts = count_inliers(source, target, hypotheses, tolerance)
        winner = int(counts.argmax())
        if counts[winner] > best_count:
            best_count, best_pose = int(counts[winner]), hypotheses[winner]
            needed = trials_needed(best_count / len(source), settings.confidence)
    if best_pose is None or best_count < settings.min_inliers:
        return None
    inlier = _inliers(source, target, best_pose, tolerance)
    refitted = fit(source[None, inlier], target[None, inlier])[0]
    return Consensus(refitted, inlier, trials)


def trials_needed(inlier_ratio: float, confidence: float) -> float:
    """The number of samples of 3 of which one is free of outliers with this confidence."""
    if inlier_ratio >= 1.0:
        return 1.0
    return float(np.log(1 - confidence) / np.log1p(-(inlier_ratio**3))) if inlier_ratio > 0 else np.inf


def fit(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Fit the rigid motions (B, 4, 4) that map B sets of points (B, n, 3) to the target's with least squares.

    Thesis (4.8)-(4.22): centred sets, H = sum p' q'^t = U L V^t, R = V U^t, V's last column negated where R mirrors.
    """
    source_mean = source.mean(axis=1, keepdims=True)
    target_mean = target.mean(axis=1, keepdims=True)
    H = np.einsum("bni,bnj->bij", source - source_mean, target - target_mean)
    U, _, Vt = np.linalg.svd(H)
    mirrored = np.linalg.det(np.einsum("bji,bkj->bik", Vt, U)) < 0
    Vt[mirrored, 2] *= -1
    T = np.zeros((len(source), 4, 4))
    T[:, :3, :3] = np.einsum("bji,bkj->bik", Vt, U)
    T[:, :3, 3] = target_mean[:, 0] - np.einsum("bij,bj->bi", T[:, :3, :3], source_mean[:, 0])
    T[:, 3, 3] = 1.0
    return T


def count_inliers(source: np.ndarray, target: np.ndarray, hypotheses: np.ndarray, tolerance: float) -> np.ndarray:
    """Count (B,) the source points (M, 3) that each motion (B, 4, 4) takes within the tolerance [m] of the target's."""
    counts = np.empty(len(hypotheses), np.int64)
    over_slices(_count_inliers, len(hypotheses), source, target, np.ascontiguousarray(hypotheses), tolerance, counts)
    return counts


def _same_shape(source: np.ndarray, target: np.ndarray, tolerance: float) -> np.ndarray:
    """Tell which samples (B, 3, 3) are triangles with sides alike in both views, longer than twice the tolerance."""
    sides, others = (np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2) for corners in (source, target))
    return ((np.abs(sides - others) < 2 * tolerance) & (np.minimum(sides, others) > 2 * tolerance)).all(axis=1)


def _inliers(source: np.ndarray, target: np.ndarray, T: np.ndarray, tolerance: float) -> np.ndarray:
    return np.linalg.norm(poses.transform(T, source) - target, axis=1) < tolerance


@kernel
def _count_inliers(
    start: int,
    stop: int,
    source: np.ndarray,
    target: np.ndarray,
    hypotheses: np.ndarray,
    tolerance: float,
    counts: np.ndarray,
) -> None:
    for b in range(start, stop):
        T = hypotheses[b]
        count = 0
        for i in range(len(source)):
            squared = 0.0
            for k in range(3):
                moved = T[k, 0] * source[i, 0] + T[k, 1] * source[i, 1] + T[k, 2] * source[i, 2] + T[k, 3]
                squared += (moved - target[i, k]) ** 2
            count += squared < tolerance * tolerance
        counts[b] = count
