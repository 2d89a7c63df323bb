"""What figures 5.8 to 5.10 are made of: five objects on virtual circles, registered by each method on its own.

The folder `registration/WAY/CIRCLE` holds what `orbitscan process` writes of one circle registered one way.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Sequence
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
from orbitscan.recorder.formats import ply
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate

OBJECTS = {  # thesis 5.2 -> focal length [pixels] at which a view has about 30,000 points, the helicopter's 105,000
    "bin": 665.0,
    "statue": 719.0,
    "helicopter": 1934.0,
    "robot": 613.0,
    "vacuum_cleaner": 637.0,
}
ELEVATION_DEG = 30.0  # from which the camera looks down on its object
CIRCLE = 250  # views, thesis 5.2
FEW = 18  # of them that are used there, 20 degrees apart
IDENTITY = "identity + refiner"  # our control: `pairwise` without any feature
THESIS = ("icp", "ransac_icp")  # the methods that figures 5.8 to 5.10 compare
QUANTITIES = ("translation_error_m", "rotation_error_chordal", "center_error_m")  # columns of errors.csv
_FOLDER = "registration"
_DENSE, _SEED = "-dense-", "-seed-"  # in the name of a circle


@dataclass(frozen=True)
class Way:
    """Methods that are run together, with their settings."""

    folder: str
    methods: tuple[Method, ...]
    settings: Settings = field(default_factory=Settings)


IDENTITY_SETTINGS = replace(Settings(), pair=replace(Settings().pair, starts=("identity",)))
WAYS = (  # each apart, so that it has its own model and its own seconds
    Way("icp", (Method.ICP,)),
    Way("ransac_icp", (Method.RANSAC_ICP,)),
    Way("identity", (Method.PAIRWISE,), IDENTITY_SETTINGS),
    Way("ours", (Method.PAIRWISE, Method.REFINED)),
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
        """The name of its recording."""
        return f"{self.what}{_DENSE if self.dense else '-sparse-'}{self.views}{_SEED}{self.seed}"

    @property
    def spacing(self) -> str:
        """How far apart neighbouring views are, in words."""
        return f"{360 / (CIRCLE if self.dense else FEW):g} degrees apart"

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
        """One of QUANTITIES for every view after the first that has an estimate."""
        return [view[name] for view in self.views[1:] if view[name] is not None]

    @property
    def unplaced(self) -> int:
        """How many views have no estimate: they have no error, and count as failed."""
        return sum(view["translation_error_m"] is None for view in self.views)


def list_circles(plan: Plan) -> list[Circle]:
    """The circles of a plan: FEW views of each object for every seed, and once the plan's fraction of CIRCLE views."""
    dense = max(FEW, round(CIRCLE * plan.fraction))
    sparse = [Circle(what, FEW, seed) for seed in plan.seeds for what in OBJECTS]
    return sparse + [Circle(what, dense, dense=True) for what in OBJECTS]


def run_all(plan: Plan) -> list[Run]:
    """Register every circle by every method; what is recorded or registered already is not done again.

    Raises what recording and processing raise.
    """
    circles = list_circles(plan)
    paths = [plan.folder / "circles" / f"{circle.name}.mcap" for circle in circles]
    for circle, path in plan.progress(zip(circles, paths, strict=True), len(circles), "Recording the circles"):
        _record(circle, path)
    for way in WAYS:
        job = Job(plan.folder / _FOLDER / way.folder, "all", way.methods, way.settings, model=None)
        outcomes = process_all(paths, job, plan.workers, isolated=False)
        for outcome in plan.progress(outcomes, len(paths), f"Registering by {way.folder}"):
            if outcome.error is not None:
                raise outcome.error
    return list(_read_all(plan, circles))


def choose_runs(runs: Sequence[Run], what: str, method: str) -> list[Run]:
    """The runs of an object by a method."""
    return [run for run in runs if run.circle.what == what and run.method == method]


def describe_runs(runs: Sequence[Run]) -> dict[str, Any]:
    """What a row of figures 5.8 and 5.10 says of the runs of an object by a method, before their numbers."""
    circle = runs[0].circle
    whole = {"object": circle.what, "views": circle.views, "part": circle.spacing}
    return whole | {"method": runs[0].method, "runs": len(runs)}


def split_by_spacing(runs: Sequence[Run]) -> tuple[list[Run], list[Run]]:
    """The runs on FEW views round the circle, and those on neighbouring views of CIRCLE."""
    return [run for run in runs if not run.circle.dense], [run for run in runs if run.circle.dense]


def describe_settings(runs: Sequence[Run]) -> dict[str, Any]:
    """What figures 5.8 and 5.10 say of how their circles were recorded and registered."""
    return {
        "elevation_deg": ELEVATION_DEG,
        "focal_pixels": OBJECTS,
        "noise_mm_at_1_m": 1,
        "icp_gate_resolutions": Settings().pair.refinement.icp_gate,
        "views_of_a_circle": CIRCLE,
        "dense_views": next(run.circle.views for run in runs if run.circle.dense),
    }


def read_frames(folder: Path) -> list[dict[str, Any]]:
    """A row for each circle, method and view of the first run in a plan's folder.

    It holds the QUANTITIES, each None where there is no estimate.
    """
    rows = []
    for way, circle, results in _find_first_run(folder):
        path = results / "errors.csv"
        if not path.exists():
            continue
        with path.open(encoding="utf-8", newline="") as stream:
            table = list(csv.DictReader(stream))
        alone = len({line["method"] for line in table}) == 1  # then the way's name tells more
        rows += [
            {"circle": circle, "method": way if alone else line["method"], "view": int(line["view"])}
            | {name: float(line[name]) if line[name] else None for name in QUANTITIES}
            for line in table
        ]
    return rows


def read_models(folder: Path) -> dict[str, dict[str, tuple[np.ndarray, np.ndarray | None]]]:
    """The models of the first run in a plan's folder, by circle of FEW views, then by way.

    Each is its points (N, 3) in metres, z up, and their colours (N, 3) uint8 or None.
    """
    models: dict[str, dict[str, tuple[np.ndarray, np.ndarray | None]]] = {}
    for way, circle, results in _find_first_run(folder):
        if _DENSE not in circle and (path := results / "model.ply").exists():
            points, colors = ply.read(path)
            models.setdefault(circle, {})[way] = (_set_upright(points), colors)
    return models


def _set_upright(points: np.ndarray) -> np.ndarray:
    """Points (N, 3) of the first camera's frame in one with x to its right, y level and away from it, z up."""
    cos, sin = np.cos(np.radians(ELEVATION_DEG)), np.sin(np.radians(ELEVATION_DEG))
    upright = np.array([[1.0, 0.0, 0.0], [0.0, -sin, cos], [0.0, -cos, -sin]])
    return points @ upright.T.astype(np.float32)


def _find_first_run(folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Way, circle and results folder of everything registered in the first run; circles of few views first."""
    end = f"{_SEED}0"
    found = [path for way in WAYS for path in (folder / _FOLDER / way.folder).glob(f"*{end}")]
    for results in sorted(found, key=lambda path: (_DENSE in path.name, path.name)):
        yield results.parent.name, results.name.removesuffix(end), results


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
            found = read_results(plan.folder / _FOLDER / way / circle.name)
            registration = found.seconds["methods"][method]["total"]
            seconds = {"registration": registration, "outlier_removal": found.seconds["outlier_removal"]}
            estimates = found.results.reconstruction[Method(method)].views
            views = [{"view": v.view, "status": v.status} | asdict(v.errors) for v in estimates]
            placed = {v.view: v.T_0_i for v in estimates if v.T_0_i is not None}
            yield Run(circle, shown, views, placed, seconds, found.results.key)
