"""Whether two surfaces agree under a pose: the only grounds on which an estimate is called right."""

from dataclasses import dataclass

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree

from processing.surface import Scale, Surface
from recorder import poses


@dataclass(frozen=True)
class JudgementSettings:
    """What counts as agreement; not in the thesis."""

    gate: float = 2.0  # multiples of the working resolution: points farther apart do not overlap
    normal_cosine: float = 0.5  # nor do surfaces that face apart by more than 60 degrees
    min_overlap: float = 0.3
    max_residual: float = 0.65  # multiples of the working resolution, besides the noise of both views: samplings of
    # one surface stay below half, surfaces that merely cross within the gate come to one
    min_score: float = 0.25  # below, a start is not worth refining, nor a pose believing
    min_observability: float = (
        0.002  # shapes of revolution stay ten times below, a cap with its brim is four times above
    )
    rival_score: float = 0.9  # a start that comes so near to the best is refined on all points too
    ambiguous_score: float = 0.98  # a runner-up with this share of the best score explains the views as well ...
    distinct_deg: float = 5.0  # ... if it is another pose: turned by more than this ...
    distinct_shift: float = 0.05  # ... or moved by more than this share of the diameter


@dataclass(frozen=True)
class Judgement:
    """How far the surfaces agree."""

    overlap: float  # share of the smaller working cloud that lies on the other, 0 to 1
    rmse: float  # distance of the overlapping points along the normal [m]
    score: float  # overlap, each point weighed by how well it fits, 0 to 1
    observability: float  # how firmly the overlap holds its weakest motion, 0 to 1; see `observability`


def judge(
    T_target_source: np.ndarray,
    source: Surface,
    target: Surface,
    target_tree: cKDTree,
    scale: Scale,
    settings: JudgementSettings,
    chosen: slice = slice(None),
) -> Judgement:
    """The agreement of the working clouds of two surfaces, by all or some chosen points of the source.

    target_tree holds the target's working points.
    """
    working = source.working[chosen]
    moved = poses.transform(T_target_source, working)
    distance, nearest = target_tree.query(
        moved, distance_upper_bound=settings.gate * scale.working, workers=get_num_threads()
    )
    near = np.isfinite(distance)
    partner = nearest[near]
    normals = target.normals[partner]
    turned = poses.transform(poses.make(T_target_source[:3, :3], np.zeros(3)), source.normals[chosen][near])
    facing = np.einsum("ni,ni->n", turned, normals)
    overlapping = facing > settings.normal_cosine  # false where either normal is NaN
    if not overlapping.any():
        return Judgement(0.0, 0.0, 0.0, 0.0)
    offset = moved[near] - target.working[partner]
    residual = np.einsum("ni,ni->n", offset, normals)[overlapping]
    smaller = len(working) * min(1.0, len(target.working) / len(source.working))
    fitting = np.maximum(0.0, 1.0 - (residual / allowed_residual(scale, settings)) ** 2 / 4)
    return Judgement(
        overlap=min(1.0, len(residual) / smaller),
        rmse=float(np.sqrt(np.mean(residual**2))),
        score=min(1.0, float(fitting.sum()) / smaller),
        observability=observability(moved[near][overlapping], turned[overlapping], normals[overlapping]),
    )


def observability(points: np.ndarray, normals: np.ndarray, partners: np.ndarray) -> float:
    """The smallest eigenvalue of the mean point-to-plane information of overlapping points (N, 3), unit motions.

    Rotations are about the centroid, their lengths in root mean square radii. The normals (N, 3) of one view are paired
    with those of the other: their noise is independent and averages out, where squaring one view's would add it. Near
    zero, some motion slides the surfaces along each other: a turn about the axis of a shape of revolution, say.
    """
    arms = points - points.mean(axis=0)
    arms /= max(np.sqrt((arms**2).sum(axis=1).mean()), 1e-12)
    one = np.hstack([np.cross(arms, normals), normals])
    other = np.hstack([np.cross(arms, partners), partners])
    information = np.einsum("ni,nj->ij", one, other) / len(points)
    return float(np.linalg.eigvalsh((information + information.T) / 2)[0])


def allowed_residual(scale: Scale, settings: JudgementSettings) -> float:
    """The largest rmse [m] two samplings of one surface show: their coarseness and the noise of both."""
    return float(np.hypot(settings.max_residual * scale.working, np.sqrt(2) * scale.noise))


def status_of(judgement: Judgement, scale: Scale, settings: JudgementSettings) -> str:
    """`ok`, `low_overlap`, `diverged` where the overlapping surfaces lie apart, `ambiguous` where they can slide."""
    if judgement.overlap < settings.min_overlap:
        return "low_overlap"
    fits = judgement.rmse <= allowed_residual(scale, settings) and judgement.score >= settings.min_score
    if not fits:
        return "diverged"
    return "ok" if judgement.observability >= settings.min_observability else "ambiguous"


def distinct(T_a: np.ndarray, T_b: np.ndarray, center: np.ndarray, scale: Scale, settings: JudgementSettings) -> bool:
    """Whether two poses of a view with this centre (3,) are different ones."""
    turned = np.degrees(poses.rotation_angle(T_a[:3, :3].T @ T_b[:3, :3]))
    shifted = np.linalg.norm(poses.transform(T_a, center[None]) - poses.transform(T_b, center[None]))
    return bool(turned > settings.distinct_deg or shifted > settings.distinct_shift * scale.diameter)


def confidence(found: Judgement, rival: float) -> float:
    """How strongly geometry speaks for a pose, 0 to 1: its score, less the more a different pose comes near it.

    An ordering, not a probability: it is not calibrated.
    """
    return found.score * (1.0 - min(1.0, rival / found.score) ** 4) if found.score > 0 else 0.0
