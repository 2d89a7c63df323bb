"""Whether two surfaces agree under a pose: the only grounds on which an estimate is called right."""

from dataclasses import dataclass, field

import numpy as np

from orbitscan.processing.registration.encounter import EncounterSettings, meet
from orbitscan.processing.registration.prepared_view import PreparedView
from orbitscan.processing.results.status import Status
from orbitscan.processing.surface.preparation import Surfels
from orbitscan.recorder import poses

_HALF = 4.0  # a residual of so many variances fits half as well as none
_MOST_VARIANCES = 25.0  # that one residual adds to the misfit: a few strays do not decide it
_RIVALRY = 4  # power of a rival's share of the best score: only near ones cost confidence


@dataclass(frozen=True)
class VerificationSettings:
    """What counts as agreement; lengths in multiples of the working resolution; not in the thesis."""

    encounter: EncounterSettings = field(default_factory=EncounterSettings)

    # The score: how well the overlap fits, times how far it reaches, less what contradicts.
    enough_overlap: float = 0.3  # a share about half of what could count: beyond, more proves little
    front_weight: float = 10.0  # of contradicting shares: where surfaces slide, few points tell
    unseen_weight: float = 5.0  # less: sensors miss some

    # When a pose is believed.
    min_overlap: float = 0.2  # share of the smaller view
    max_misfit: float = 2.3  # rmse in standard deviations; surfaces that merely cross within the gate come to three
    max_violations: float = 0.04  # share of the surfels in front of a surface
    strict_violations: float = 0.02  # of them and those unseen, where the views nearly slide: few points tell there
    sliding_misfit: float = 1.2  # times the session's usual one: a pair that nearly slides must fit as closely
    min_score: float = 0.2  # below, a start is not worth refining, nor a pose believing

    # When another pose is another.
    distinct_deg: float = 5.0  # it is turned by more than this ...
    distinct_shift: float = 0.05  # ... or moved by more than this share of the diameter


@dataclass(frozen=True)
class Verification:
    """How far the surfaces agree.

    Shares are means of both directions, the source's surfels in the target and the target's in the source, each
    counted against the surfels of the smaller view.
    """

    overlap: float  # share of the surfels that lie on the other view, 0 to 1
    rmse: float  # distance of the overlapping surfels along the normal [m]
    misfit: float  # the same in standard deviations of single points: less than one where the surfaces are the same
    violations: float  # share of the surfels that lie in front of a surface the other sensor saw
    unseen: float  # share of the surfels that face the other sensor, which saw nothing there
    score: float  # how well the overlap fits, the less the smaller it is, less what contradicts; at most 1


@dataclass(frozen=True)
class _Count:
    """What one view's surfels find in the other: numbers of surfels, and sums over the overlapping ones."""

    surfels: int  # looked at, perhaps a few that stand for all
    overlapping: int
    squares: float  # of residuals [m^2]
    misfits: float  # the same in variances
    fitting: float  # 1 for each that fits exactly, less for others
    in_front: int
    unseen: int


def verify(
    T_target_source: np.ndarray,
    source: PreparedView,
    target: PreparedView,
    settings: VerificationSettings,
    coarse: bool = False,
) -> Verification:
    """Measure how far two views agree under a pose, by their judged surfels or only the coarse ones."""
    ours, theirs = (view.coarse_surfels if coarse else view.judged_surfels for view in (source, target))
    forth = _compare(T_target_source, ours, target, settings)
    back = _compare(poses.invert(T_target_source), theirs, source, settings)
    overlapping = forth.overlapping + back.overlapping
    if not overlapping:
        return Verification(overlap=0.0, rmse=0.0, misfit=np.inf, violations=1.0, unseen=1.0, score=0.0)
    smaller = min(len(source.surface.surfels), len(target.surface.surfels))
    of_forth = min(1.0, smaller / len(source.surface.surfels)) * forth.surfels
    of_back = min(1.0, smaller / len(target.surface.surfels)) * back.surfels

    def share(forth: float, back: float) -> float:
        return (forth / of_forth + back / of_back) / 2

    overlap = share(forth.overlapping, back.overlapping)
    fitting = share(forth.fitting, back.fitting)
    violations, unseen = share(forth.in_front, back.in_front), share(forth.unseen, back.unseen)
    reach = min(1.0, (1 + settings.enough_overlap) * overlap / (overlap + settings.enough_overlap))
    return Verification(
        overlap=min(1.0, overlap),
        rmse=float(np.sqrt((forth.squares + back.squares) / overlapping)),
        misfit=float(np.sqrt((forth.misfits + back.misfits) / overlapping)),
        violations=violations,
        unseen=unseen,
        score=fitting / overlap * reach - settings.front_weight * violations - settings.unseen_weight * unseen,
    )


def _compare(T: np.ndarray, surfels: Surfels, other: PreparedView, settings: VerificationSettings) -> _Count:
    found = meet(T, surfels, other, settings.encounter)
    misfits = found.residuals**2 / found.variances
    return _Count(
        surfels=len(surfels),
        overlapping=len(found.residuals),
        squares=float((found.residuals**2).sum()),
        misfits=float(np.minimum(misfits, _MOST_VARIANCES).sum()),
        fitting=float((1.0 / (1.0 + misfits / _HALF)).sum()),
        in_front=int(found.in_front.sum()),
        unseen=int(found.unseen.sum()),
    )


def status_of(found: Verification, settings: VerificationSettings, nearly_slides: bool = False) -> Status:
    """`ok`, `low_overlap`, `inconsistent` where a surface is seen through another, `diverged` where they lie apart.

    Where the views nearly slide along each other, surfels that should have been seen and were not count too.
    """
    if found.overlap < settings.min_overlap:
        return Status.LOW_OVERLAP
    if found.violations > settings.max_violations:
        return Status.INCONSISTENT
    if nearly_slides and found.violations + found.unseen > settings.strict_violations:
        return Status.INCONSISTENT
    fits = found.misfit <= settings.max_misfit and found.score >= settings.min_score
    return Status.OK if fits else Status.DIVERGED


def distance(T_a: np.ndarray, T_b: np.ndarray, source: PreparedView, settings: VerificationSettings) -> float:
    """Measure how different two poses of the source are: 1 where they just count as distinct."""
    apart = T_a - T_b
    turned = np.degrees(poses.angle_between(T_a[:3, :3], T_b[:3, :3]))
    shifted = float(np.linalg.norm(apart[:3, :3] @ source.middle + apart[:3, 3]))
    return max(turned / settings.distinct_deg, shifted / (settings.distinct_shift * source.scale.diameter))


def confidence(found: Verification, rival: float) -> float:
    """How strongly geometry speaks for a pose, 0 to 1: its score, the less the nearer a rival's score comes to it.

    An ordering, not a probability: it is not calibrated.
    """
    return found.score * (1.0 - min(1.0, max(0.0, rival) / found.score) ** _RIVALRY) if found.score > 0 else 0.0
