"""An estimate against the truth: how far off, how far in units of its floor, and right or wrong.

A pair is wrong when, the motions it declares free taken out, it is off by more than 5 degrees or the object's centre by
more than 5 % of the object's diameter; or when it declares a motion free on an object that has none. Peers cannot
declare anything, so what the surfaces truly leave free is taken out for them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from orbitscan.processing.pose_errors import center_error, rotation_error, rotation_error_deg
from orbitscan.recorder import poses
from tests.benchmarks import floor
from tests.benchmarks.sessions import ASYMMETRIC, Case, Scan

WRONG_DEG, WRONG_SHARE = 5.0, 0.05
NO_MOTION = np.zeros((6, 0))


@dataclass(frozen=True)
class PairScore:
    """A pair by a method; None where there is no estimate, or no noise and so no floor."""

    case: Case
    method: str
    source: int
    target: int
    status: str
    ok: bool
    right: bool
    false_freedom: bool  # declares a motion free on an object that has none
    error_deg: float | None  # as it is
    error_mm: float | None  # of the object's centre
    observable_deg: float | None  # declared free motions taken out
    observable_mm: float | None
    determined_deg: float | None  # also those taken out that the surfaces leave free
    determined_mm: float | None
    floor_deg: float | None
    floor_mm: float | None
    free_motions: int  # that the surfaces leave
    freedoms: Sequence[Mapping[str, Any]]  # declared
    confidence: float | None
    evidence: Mapping[str, Any]
    candidates: Sequence[Mapping[str, Any]]
    seconds: float | None

    @property
    def ratio(self) -> float | None:
        """Rotation error / floor."""
        return self.determined_deg / self.floor_deg if self.determined_deg is not None and self.floor_deg else None

    @property
    def center_ratio(self) -> float | None:
        """Centre error / floor."""
        return self.determined_mm / self.floor_mm if self.determined_mm is not None and self.floor_mm else None


@dataclass(frozen=True)
class SessionScore:
    """A session by a method."""

    case: Case
    method: str
    views: int
    failed_views: int
    max_chordal: float | None  # of T_0_i, what the surfaces leave free taken out
    chain_ratio: float | None  # largest chordal error / chordal floor of a chain with known shape
    seconds: Mapping[str, float]  # by stage


def score_pair(
    scan: Scan,
    method: str,
    source: int,
    target: int,
    T_target_source: np.ndarray | None,
    *,
    status: str = "ok",
    freedoms: Sequence[Any] | None = (),
    confidence: float | None = None,
    evidence: Mapping[str, Any] | None = None,
    candidates: Sequence[Mapping[str, Any]] = (),
    seconds: float | None = None,
) -> PairScore:
    """The score of a pair; `freedoms` are declared, None grants those that there are (for peers)."""
    truth = scan.session.truth()
    T_object_target = truth[target]
    information = scan.overlap(source, target)
    about = information or scan.localized(target, scan.diameter / 4)
    free = about.free()
    declared = free if freedoms is None else _twists(freedoms, T_object_target, about)
    false_freedom = bool(freedoms) and scan.case.object in ASYMMETRIC
    errors: list[tuple[float | None, float | None]] = [(None, None)] * 3
    if T_target_source is not None:
        T_true = poses.invert(T_object_target) @ truth[source]
        error = T_object_target @ T_target_source @ poses.invert(T_true) @ poses.invert(T_object_target)
        bases = NO_MOTION, declared, floor.joined(declared, free)
        errors = [_measure(floor.take_out(error, basis, about.center, about.lever), scan.center) for basis in bases]
    floors = (None, None)
    if information and scan.case.noise:
        covariance = information.covariance(bases[2] if T_target_source is not None else free)
        millimetres = 1e3 * floor.center_floor(covariance, information.center, scan.center)
        floors = floor.rotation_floor_deg(covariance), millimetres
    degrees, millimetres = errors[1]
    close = degrees is not None and degrees <= WRONG_DEG and millimetres <= WRONG_SHARE * 1e3 * scan.diameter
    return PairScore(
        scan.case, method, source, target, status, status == "ok", close and not false_freedom, false_freedom,
        *errors[0], *errors[1], *errors[2], *floors, free.shape[1],
        [_plain(freedom) for freedom in freedoms or ()], confidence, evidence or {}, candidates, seconds,
    )  # fmt: skip


def score_session(
    scan: Scan, method: str, estimates: Mapping[int, np.ndarray | None], failed: int, seconds: Mapping[str, float]
) -> SessionScore:
    """The score of composed poses T_0_i by recorded index; the first of them is view {0}."""
    truth = scan.session.truth()
    origin, *others = estimates
    lever = scan.diameter / 4
    first = scan.localized(origin, lever)
    chordals, ratios = [], []
    for view in others:
        T = estimates[view]
        if T is None:
            continue
        error = truth[origin] @ T @ poses.invert(truth[view])
        information = scan.localized(view, lever)
        free = floor.joined(first.free(), information.free())
        chordals.append(rotation_error(np.eye(4), floor.take_out(error, free, scan.center, lever)))
        angle = np.radians(floor.rotation_floor_deg(floor.chain_covariance(first, information, free)))
        ratios.append(chordals[-1] / (2 * np.sqrt(2) * np.sin(angle / 2)))
    return SessionScore(
        scan.case,
        method,
        len(estimates),
        failed,
        max(chordals, default=None),
        max(ratios, default=None) if scan.case.noise else None,
        seconds,
    )


def _measure(error: np.ndarray, center: np.ndarray) -> tuple[float, float]:
    """Degrees, and millimetres of the object's centre."""
    return rotation_error_deg(np.eye(4), error), 1e3 * center_error(np.eye(4), error, center)


def _twists(freedoms: Sequence[Any], T_object_target: np.ndarray, about: floor.Information) -> np.ndarray:
    """(6, k) orthonormal: declared free motions, in the target's frame, as motions in the object's."""
    twists = [
        about.twist(
            T_object_target[:3, :3] @ freedom.axis,
            poses.transform(T_object_target, np.asarray(freedom.point)[None])[0],
            freedom.kind,
        )
        for freedom in freedoms
    ]
    return floor.joined(NO_MOTION, *(twist[:, None] for twist in twists))


def _plain(freedom: Any) -> dict[str, Any]:
    return {"axis": list(map(float, freedom.axis)), "point": list(map(float, freedom.point)), "kind": freedom.kind}
