"""Whether two surfaces agree under a pose: the only grounds on which an estimate is called right."""

from dataclasses import dataclass

import numpy as np

from processing.reconstruction.free_space import look_up
from processing.reconstruction.prepared import Prepared
from processing.reconstruction.refinement import find_partners
from processing.surface import Surfels
from recorder import poses


@dataclass(frozen=True)
class JudgementSettings:
    """What counts as agreement; lengths in multiples of the working resolution; not in the thesis."""

    gate: float = 2.0  # points farther apart do not overlap
    deviation: float = 0.2  # of a residual, besides what both surfels' variances explain
    enough_overlap: float = 0.3  # a share on which the score is half of what it can be: beyond, more proves little
    front: float = 1.5  # a point so far before a surface, and four times the noise, contradicts it ...
    front_weight: float = 10.0  # and outweighs so many that fit: where surfaces slide, few points tell
    grazing_cosine: float = 0.35  # unless the other sensor would see it edge-on, and may have missed it
    unseen_cosine: float = 0.45  # a point that faces a sensor so should have been seen by it
    unseen_weight: float = 5.0  # of one that was not: sensors miss some
    min_overlap: float = 0.2
    max_misfit: float = 2.3  # rmse in standard deviations; surfaces that merely cross within the gate come to three
    max_violations: float = 0.04  # share of the surfels
    strict_violations: float = 0.02  # of them and those unseen, where the views nearly slide: few points tell there
    sliding_misfit: float = 1.2  # times the session's usual one: a pair that nearly slides must fit as closely
    min_score: float = 0.2  # below, a start is not worth refining, nor a pose believing
    rival_score: float = 0.8  # a start that comes so near to the best is refined on all surfels too
    ambiguous_score: float = 0.97  # a runner-up with this share of the best score explains the views as well ...
    ambiguous_misfit: float = 1.08  # ... if it fits as closely up to this factor ...
    distinct_deg: float = 5.0  # ... if it is another pose: turned by more than this ...
    distinct_shift: float = 0.05  # ... or moved by more than this share of the diameter


@dataclass(frozen=True)
class Judgement:
    """How far the surfaces agree; shares are means over both directions, source on target and target on source."""

    overlap: float  # share of the smaller view's surfels that lie on the other, 0 to 1
    rmse: float  # distance of the overlapping surfels along the normal [m]
    misfit: float  # the same in standard deviations of single points: less than one where the surfaces are the same
    violations: float  # share of the surfels that lie in front of a surface the other sensor saw
    unseen: float  # share of the surfels that face the other sensor, which saw nothing there
    score: float  # how well the overlap fits, the less the smaller it is, and less what contradicts; at most 1


@dataclass(frozen=True)
class _Count:
    """What one view's surfels find in the other."""

    surfels: int
    overlapping: int
    squares: float  # of residuals [m^2]
    misfits: float  # the same in variances
    fitting: float  # overlapping ones weighed by how well they fit
    in_front: int
    unseen: int


def judge(
    T_target_source: np.ndarray,
    source: Prepared,
    target: Prepared,
    settings: JudgementSettings,
    few: bool = False,
) -> Judgement:
    """The agreement of two views under a pose, by many or a few of their surfels."""
    forth = _compare(T_target_source, source.few if few else source.many, target, settings)
    back = poses.invert(T_target_source)
    back = _compare(back, target.few if few else target.many, source, settings)
    smaller = min(len(source.surface.surfels), len(target.surface.surfels))
    shares = (
        min(1.0, smaller / len(source.surface.surfels)) * forth.surfels,
        min(1.0, smaller / len(target.surface.surfels)) * back.surfels,
    )

    def mean(of: str) -> float:
        return (getattr(forth, of) / shares[0] + getattr(back, of) / shares[1]) / 2

    overlapping = forth.overlapping + back.overlapping
    fitting, in_front, unseen = mean("fitting"), mean("in_front"), mean("unseen")
    overlap = mean("overlapping")
    met = min(1.0, (1 + settings.enough_overlap) * overlap / (overlap + settings.enough_overlap))
    if not overlapping:
        return Judgement(0.0, 0.0, np.inf, 1.0, 1.0, 0.0)
    return Judgement(
        overlap=min(1.0, overlap),
        rmse=float(np.sqrt((forth.squares + back.squares) / overlapping)),
        misfit=float(np.sqrt((forth.misfits + back.misfits) / overlapping)),
        violations=in_front,
        unseen=unseen,
        score=fitting / overlap * met - settings.front_weight * in_front - settings.unseen_weight * unseen,
    )


def _compare(T: np.ndarray, surfels: Surfels, other: Prepared, settings: JudgementSettings) -> _Count:
    w = other.scale.working
    moved = poses.transform(T, surfels.points)
    normals = poses.transform(poses.make(T[:3, :3], np.zeros(3)), surfels.normals)
    partner = find_partners(moved, normals, other.fine, settings.gate * w)
    near = partner >= 0
    partner = partner[near]
    along = normals[near] + other.fine.normals[partner]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    residual = np.einsum("ni,ni->n", moved[near] - other.fine.grid.points[partner], along)
    variance = surfels.variances[near] + other.fine.variances[partner] + (settings.deviation * w) ** 2
    misfits = residual**2 / variance
    in_front = unseen = 0
    if other.range_image is not None and not near.all():
        far, facing = moved[~near], normals[~near]
        before, nothing = look_up(other.range_image, far, settings.front * w + 4 * other.scale.noise)
        to_sensor = other.surface.sensor_origin - far
        cosine = np.einsum("ni,ni->n", facing, to_sensor) / np.linalg.norm(to_sensor, axis=1)
        in_front = int((before & (np.abs(cosine) > settings.grazing_cosine)).sum())
        unseen = int((nothing & (cosine > settings.unseen_cosine)).sum())
    return _Count(
        surfels=len(surfels),
        overlapping=len(partner),
        squares=float((residual**2).sum()),
        misfits=float(np.minimum(misfits, 25.0).sum()),
        fitting=float((1.0 / (1.0 + misfits / 4.0)).sum()),
        in_front=in_front,
        unseen=unseen,
    )


def status_of(judgement: Judgement, settings: JudgementSettings, nearly_slides: bool = False) -> str:
    """`ok`, `low_overlap`, `inconsistent` where a surface is seen through another, `diverged` where they lie apart."""
    if judgement.overlap < settings.min_overlap:
        return "low_overlap"
    if judgement.violations > settings.max_violations:
        return "inconsistent"
    if nearly_slides and judgement.violations + judgement.unseen > settings.strict_violations:
        return "inconsistent"
    fits = judgement.misfit <= settings.max_misfit and judgement.score >= settings.min_score
    return "ok" if fits else "diverged"


def as_good(judgement: Judgement, best: Judgement, settings: JudgementSettings) -> bool:
    """Whether another pose of the same views explains them as well as the best one."""
    as_close = judgement.misfit <= settings.ambiguous_misfit * best.misfit
    return as_close and judgement.score >= settings.ambiguous_score * best.score


def distance(T_a: np.ndarray, T_b: np.ndarray, source: Prepared, settings: JudgementSettings) -> float:
    """How different two poses of the source are: 1 where they just count as distinct."""
    center = source.few.points.mean(axis=0)[None]
    turned = np.degrees(poses.rotation_angle(T_a[:3, :3].T @ T_b[:3, :3]))
    shifted = float(np.linalg.norm(poses.transform(T_a, center) - poses.transform(T_b, center)))
    return max(turned / settings.distinct_deg, shifted / (settings.distinct_shift * source.scale.diameter))


def confidence(found: Judgement, rival: float) -> float:
    """How strongly geometry speaks for a pose, 0 to 1: its score, less the more a different pose comes near it.

    An ordering, not a probability: it is not calibrated.
    """
    return found.score * (1.0 - min(1.0, max(0.0, rival) / found.score) ** 4) if found.score > 0 else 0.0
