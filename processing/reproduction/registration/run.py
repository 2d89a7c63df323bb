"""What figures 5.8 to 5.10 are made of: five objects on virtual circles, registered by each method on its own."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.processing.batch.recording import Job
from orbitscan.processing.batch.workers import process_all
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.results.folder import read_results
from orbitscan.processing.results.status import Method
from orbitscan.processing.settings import Settings
from orbitscan.recorder import mcap_file
from orbitscan.recorder.atomic import write_whole
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate

OBJECTS = {  # thesis 5.2 -> focal length [pixels] at which a view has about 30,000 points, the helicopter's 105,000
    "bin": 665.0,
    "statue": 719.0,
    "helicopter": 1934.0,
    "robot": 613.0,
    "vacuum_cleaner": 637.0,
}
ELEVATION_DEG = 30.0  # of the camera
CIRCLE = 250  # views, thesis 5.2
FEW = 18  # of them that are used there, 20 degrees apart
IDENTITY = "identity + refiner"  # our control: `pairwise` without any feature


@dataclass(frozen=True)
class Way:
    """Methods that are run together."""

    folder: str
    methods: tuple[str, ...]
    settings: Settings = field(default_factory=Settings)


_PAIR = Settings().pair
WAYS = (  # each apart, so that it has its own model and its own seconds
    Way("icp", ("icp",)),
    Way("ransac_icp", ("ransac_icp",)),
    Way("identity", ("pairwise",), replace(Settings(), pair=replace(_PAIR, starts=("identity",)))),
    Way("ours", ("pairwise", "refined")),
)
METHODS = {  # as they are shown -> the way, and the method in its results
    "icp": ("icp", "icp"),
    "ransac_icp": ("ransac_icp", "ransac_icp"),
    IDENTITY: ("identity", "pairwise"),
    "pairwise": ("ours", "pairwise"),
    "refined": ("ours", "refined"),
}


@dataclass(frozen=True)
class Circle:
    """Views of an object by a camera that goes round it."""

    what: str
    views: int
    seed: int = 0  # of the noise
    dense: bool = False  # 360 / CIRCLE degrees apart; else FEW views go round

    @property
    def name(self) -> str:
        """Of its recording."""
        return f"{self.what}-{'dense' if self.dense else 'sparse'}-{self.views}-seed-{self.seed}"

    @property
    def key(self) -> dict[str, Any]:
        """All that its recording depends on."""
        turn = {"views_per_turn": CIRCLE if self.dense else FEW, "elevation_deg": ELEVATION_DEG}
        return {"orbitscan": version("orbitscan"), "focal_pixels": OBJECTS[self.what]} | turn | asdict(self)


@dataclass(frozen=True, eq=False)
class Run:
    """What one method made of one circle."""

    circle: Circle
    method: str  # of METHODS
    views: list[dict[str, Any]]  # of results.json: view, status, errors (None where there is no estimate)
    poses: dict[int, np.ndarray]  # T_0_i of every view that has an estimate
    seconds: dict[str, float]  # registration, outlier_removal
    key: dict[str, Any] = field(default_factory=dict)  # all that it depends on, as its results hold it

    def errors(self, name: str) -> list[float]:
        """One of the errors of every view after the first that has an estimate."""
        return [view[name] for view in self.views[1:] if view[name] is not None]

    @property
    def unplaced(self) -> int:
        """Views without an estimate: they have no error, and count as failed."""
        return sum(view["translation_error_m"] is None for view in self.views)


def list_circles(plan: Plan) -> list[Circle]:
    """FEW views of each object for every seed, and once its whole circle, or as much of it as the plan's fraction."""
    dense = max(FEW, round(CIRCLE * plan.fraction))
    sparse = [Circle(what, FEW, seed) for seed in plan.seeds for what in OBJECTS]
    return sparse + [Circle(what, dense, dense=True) for what in OBJECTS]


def run_all(plan: Plan) -> list[Run]:
    """Every circle by every method; what is recorded or registered already is not done again.

    Raises what recording and processing raise.
    """
    circles = list_circles(plan)
    paths = [plan.folder / "circles" / f"{circle.name}.mcap" for circle in circles]
    for circle, path in plan.progress(zip(circles, paths, strict=True), len(circles), "Recording the circles"):
        _record(circle, path)
    for way in WAYS:
        job = Job(plan.folder / "registration" / way.folder, "all", way.methods, way.settings, model=None)
        outcomes = process_all(paths, job, plan.workers, isolated=False)
        for outcome in plan.progress(outcomes, len(paths), f"Registering by {way.folder}"):
            if outcome.error is not None:
                raise outcome.error
    return list(_read_all(plan, circles))


def _record(circle: Circle, path: Path) -> None:
    """Render a circle, unless its recording is there; a file beside it says what it was recorded from."""
    note, key = path.with_suffix(".json"), json.dumps(circle.key, indent=1) + "\n"
    if path.exists() and note.exists() and note.read_text(encoding="utf-8") == key:
        return
    session = simulate(
        circle.what,
        views=circle.key["views_per_turn"],
        elevation_deg=ELEVATION_DEG,
        focal=OBJECTS[circle.what],
        seed=circle.seed,
        name=circle.name,
    )
    note.unlink(missing_ok=True)
    mcap_file.write(first_views(session, circle.views), path)
    write_whole(note, key)


def _read_all(plan: Plan, circles: list[Circle]) -> Iterator[Run]:
    for circle in circles:
        for shown, (way, method) in METHODS.items():
            folder = plan.folder / "registration" / way / circle.name
            found = read_results(folder)
            seconds = {
                "registration": found.seconds["methods"][method]["total"],
                "outlier_removal": found.seconds["outlier_removal"],
            }
            estimates = found.results.reconstruction[Method(method)].views
            views = [{"view": v.view, "status": v.status} | asdict(v.errors) for v in estimates]
            placed = {v.view: v.T_0_i for v in estimates if v.T_0_i is not None}
            yield Run(circle, shown, views, placed, seconds, found.results.key)
