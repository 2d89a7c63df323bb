"""What the overlap study is made of: pairs of views, far apart on a circle, registered from turned starts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from orbitscan.processing.pipeline import process
from orbitscan.processing.pose_errors import with_errors
from orbitscan.processing.reproduction.registration.run import IDENTITY, IDENTITY_SETTINGS
from orbitscan.processing.results.estimates import PairEstimate
from orbitscan.processing.results.records import SessionResult
from orbitscan.processing.settings import Settings
from orbitscan.recorder import poses
from orbitscan.recorder.session import Session, SessionInfo, View, in_memory
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.camera import simulate

METHODS = ("icp", "ransac_icp", IDENTITY, "pairwise")
STEP_DEG = 10  # between the views of the circle; azimuths are multiples of it
FIRST_DEG = 37.0  # from one run's first view to the next run's
GATE_SHARE = 0.01  # of the diameter: so near another view's point, a point is overlapped


@dataclass(frozen=True)
class Pairs:
    """Two views of an object, `azimuth_deg` apart, to be registered from every start."""

    what: str
    azimuth_deg: int
    starts_deg: tuple[int, ...]
    seed: int

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"overlap-{self.what}-{self.azimuth_deg}-seed-{self.seed}"

    @property
    def key(self) -> dict[str, Any]:
        """All that its result depends on, as JSON holds it."""
        how = {"study": "overlap", "step_deg": STEP_DEG, "first_deg": FIRST_DEG, "overlap_gate": GATE_SHARE}
        return asdict(self) | how | {"settings": asdict(Settings())}


def register_pairs(task: Pairs) -> dict[str, Any]:
    """Register a pair: its overlap, the diameter [m], and for each start and method a trial with status and errors."""
    circle = simulate(task.what, views=360 // STEP_DEG, seed=task.seed, start_deg=FIRST_DEG * task.seed)
    low, high = objects.build(task.what, 1).bounds
    diameter = float(np.linalg.norm(high - low))
    source = task.azimuth_deg // STEP_DEG
    trials = []
    for start in task.starts_deg:
        session = pair_up(circle, source, start)
        truth = session.truth()
        off = float(np.degrees(poses.rotation_angle(truth[0][:3, :3].T @ truth[1][:3, :3])))  # the identity
        for method, pair in _register(session, task.seed):
            trials.append({"start_deg": start, "start_error_deg": off, "method": method} | _describe(pair))
    return {"overlap": measure_overlap(circle, source, diameter), "diameter_m": diameter, "trials": trials}


def pair_up(circle: Session, source: int, turn_deg: float) -> Session:
    """A session of view 0 and a source view whose camera is rolled about the ray to the middle of what it sees.

    Of all axes it is the one that leaves the cloud's middle and its sensor, which free space is told from, where they
    are: only the start's angle changes. The view's own motion adds to it (see `start_error_deg` of a trial): where
    views are near, the start is off by about the roll; where they are far, a roll may even bring it nearer.
    """
    target, view = circle.load(0), circle.load(source)
    middle = view.points.mean(axis=0, dtype=np.float64)
    axis = middle / np.linalg.norm(middle)
    roll = poses.make(Rotation.from_rotvec(np.radians(turn_deg) * axis).as_matrix(), np.zeros(3))
    rolled = poses.transform(roll, view.points).astype(np.float32)
    truth = circle.truth()
    return in_memory(
        SessionInfo(name=f"{circle.info.name}-{source}", views=2),
        [replace(target, index=0), View(1, view.name, view.stamp_ns, rolled, view.colors)],
        {0: truth[0], 1: truth[source] @ poses.invert(roll)},
    )


def measure_overlap(circle: Session, source: int, diameter: float) -> float:
    """The share of the source's points, placed by the truth, that lie within GATE_SHARE diameters of view 0's."""
    truth = circle.truth()
    placed = poses.transform(poses.invert(truth[0]) @ truth[source], circle.load(source).points)
    distances, _ = cKDTree(circle.load(0).points).query(placed, distance_upper_bound=GATE_SHARE * diameter)
    return float(np.isfinite(distances).mean())


def _register(session: Session, seed: int) -> Iterator[tuple[str, PairEstimate]]:
    """Each method's name and its estimate of the pair; the truth is used afterwards, for the errors alone."""
    for settings, methods, named in (
        (Settings(), ("icp", "ransac_icp", "pairwise"), {}),
        (IDENTITY_SETTINGS, ("pairwise",), {"pairwise": IDENTITY}),
    ):
        estimates = process(session.views(), session.info, settings, methods, seed)
        *_, result = with_errors(estimates, session.truth())
        assert isinstance(result, SessionResult)
        for method, found in result.reconstruction.items():
            yield named.get(method, method), found.pairs[0]


def _describe(pair: PairEstimate) -> dict[str, Any]:
    """The status and errors of a pair, None without an estimate; observable ones leave out motions declared free."""
    errors = pair.errors
    return {
        "status": pair.status,
        "error_deg": errors.rotation_error_deg,
        "error_m": errors.center_error_m,
        "observable_deg": errors.rotation_error_deg_observable,
        "observable_m": errors.center_error_m_observable,
    }
