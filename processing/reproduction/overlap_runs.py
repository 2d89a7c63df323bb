"""What the overlap study is made of: pairs of views, far apart on a circle, registered from turned starts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from processing.errors import with_errors
from processing.pipeline import process
from processing.results.records import PairEstimate, SessionResult
from processing.settings import Settings
from recorder import objects, poses
from recorder.session import Session, SessionInfo, View, in_memory
from recorder.sources.virtual import simulate

IDENTITY = "identity + refiner"  # our control: `pairwise` without any feature
METHODS = ("icp", "ransac_icp", IDENTITY, "pairwise")
STEP_DEG = 10  # between the views of the circle; azimuths are multiples of it
FIRST_DEG = 37.0  # from one run's first view to the next run's
MOST_DEG, MOST_SHARE = 5.0, 0.05  # a pose farther off, in degrees or diameters, is wrong
GATE_SHARE = 0.01  # of the diameter: so near another view's point, a point is overlapped
_STARTS = ("identity",)


@dataclass(frozen=True)
class Pairs:
    """An object seen from one place, paired with views farther and farther round; each pair from every start."""

    what: str
    azimuths_deg: tuple[int, ...]
    starts_deg: tuple[int, ...]
    seed: int

    @property
    def name(self) -> str:
        """Of its file."""
        return f"overlap-{self.what}-seed-{self.seed}"

    @property
    def key(self) -> dict[str, Any]:
        """What its result depends on."""
        return asdict(self) | {"settings": asdict(Settings()), "study": "overlap"}


def register_pairs(task: Pairs) -> dict[str, Any]:
    """A trial for each azimuth, start and method: the overlap, and how the estimate does."""
    circle = simulate(task.what, views=360 // STEP_DEG, seed=task.seed, start_deg=FIRST_DEG * task.seed)
    low, high = objects.build(task.what, 1).bounds
    diameter = float(np.linalg.norm(high - low))
    trials = []
    for azimuth in task.azimuths_deg:
        source = azimuth // STEP_DEG
        overlap = _overlap(circle, source, GATE_SHARE * diameter)
        for start in task.starts_deg:
            for method, pair in _register(pair_up(circle, source, start), task.seed):
                trial = {"azimuth_deg": azimuth, "start_deg": start, "method": method, "overlap": overlap}
                trials.append(trial | _judge(pair, diameter))
    return {"trials": trials}


def pair_up(circle: Session, source: int, turn_deg: float) -> Session:
    """View 0 and a source view whose camera is rolled about the ray to the middle of what it sees.

    So the start is `turn_deg` farther from the truth, while the cloud's middle and its sensor, which free space is
    told from, stay where they are.
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


def _register(session: Session, seed: int) -> Iterator[tuple[str, PairEstimate]]:
    """The pair by each method, by nothing but the page; the truth comes after it."""
    identity = replace(Settings(), pair=replace(Settings().pair, starts=_STARTS))
    for settings, methods, named in (
        (Settings(), ("icp", "ransac_icp", "pairwise"), {}),
        (identity, ("pairwise",), {"pairwise": IDENTITY}),
    ):
        estimates = process(session.views(), session.info, settings, methods, seed)
        *_, result = with_errors(estimates, session.truth())
        assert isinstance(result, SessionResult)
        for method, found in result.reconstruction.items():
            yield named.get(method, method), found.pairs[0]


def _judge(pair: PairEstimate, diameter: float) -> dict[str, Any]:
    """Errors, success, and whether it is wrong in what it claims: `ok`, after the motions it declares free."""
    errors = pair.errors
    return {
        "status": pair.status,
        "rotation_error_deg": errors.rotation_error_deg,
        "center_error_m": errors.center_error_m,
        "success": _near(errors.rotation_error_deg, errors.center_error_m, diameter),
        "ok_but_wrong": pair.status == "ok"
        and not _near(errors.rotation_error_deg_observable, errors.center_error_m_observable, diameter),
    }


def _near(degrees: float | None, metres: float | None, diameter: float) -> bool:
    return degrees is not None and metres is not None and degrees <= MOST_DEG and metres <= MOST_SHARE * diameter


def _overlap(circle: Session, source: int, gate: float) -> float:
    """The share of the source's points that view 0 has a point near, where the truth puts them."""
    truth = circle.truth()
    placed = poses.transform(poses.invert(truth[0]) @ truth[source], circle.load(source).points)
    distances, _ = cKDTree(circle.load(0).points).query(placed, distance_upper_bound=gate)
    return float(np.isfinite(distances).mean())


def collect(results: Sequence[dict[str, Any]], tasks: Sequence[Pairs]) -> list[dict[str, Any]]:
    """All trials, each with its object and run."""
    return [
        {"object": task.what, "run": task.seed} | trial
        for task, result in zip(tasks, results, strict=True)
        for trial in result["trials"]
    ]
