"""The thesis's data from virtual objects: every instance on its circles, at three camera heights, before a Kinect."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from typing import Literal

from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import InvalidOption, UnwritableOutput
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation.camera import simulate

INSTANCES = {  # thesis table 3.1; the last of each is the test instance
    "apple": 5,
    "bell_pepper": 6,
    "bowl": 6,
    "cap": 4,
    "cell_phone": 5,
    "coffee_mug": 8,
    "dry_battery": 6,
    "notebook": 5,
    "pliers": 6,
    "water_bottle": 10,
}
OTHER_INSTANCES = 3  # of every other thing
RUNS = {  # thesis table 3.2: into how many equal runs a circle is cut; 1 where it is not named
    **dict.fromkeys(("cap", "cell_phone", "pliers"), 6),
    **dict.fromkeys(("coffee_mug", "dry_battery", "notebook"), 4),
}
ELEVATIONS_DEG = {1: 30.0, 2: 45.0, 4: 60.0}  # of the camera, by the Washington dataset's number of the video
DEFAULT_VIEWS = 200  # of a circle


@dataclass(frozen=True)
class Circle:
    """One turn around one instance of a category."""

    category: str
    instance: int
    video: int

    @property
    def name(self) -> str:
        """As the Washington dataset names it."""
        return f"{self.category}_{self.instance}_{self.video}"

    @property
    def start_deg(self) -> float:
        """The front, minus half a run: a run means the same side in every instance."""
        return -180 / RUNS.get(self.category, 1)


@dataclass(frozen=True)
class Camera:
    """How the circles are recorded; None: as `simulate` chooses for the sensor."""

    views: int = DEFAULT_VIEWS
    every: int = 1
    sensor: Literal["gaussian", "kinect"] = "kinect"
    distance: float | None = None
    focal: float | None = None
    noise_mm: float = 1.0
    seed: int = 0
    threads: int = 0


@dataclass(frozen=True)
class Recorded:
    """A circle's recording."""

    path: Path
    views: int
    kept: bool  # it was there already


def plan(instances: Mapping[str, int]) -> tuple[Circle, ...]:
    """The circles of a corpus with so many instances of each category."""
    return tuple(
        Circle(category, instance, video)
        for category, count in instances.items()
        for instance in range(1, count + 1)
        for video in ELEVATIONS_DEG
    )


def open_circle(circle: Circle, camera: Camera) -> Session:
    """The session of a circle; views are rendered when loaded. Raises InvalidOption."""
    return simulate(
        circle.category,
        instance=circle.instance,
        views=camera.views,
        every=camera.every,
        elevation_deg=ELEVATIONS_DEG[circle.video],
        start_deg=circle.start_deg,
        name=circle.name,
        sensor=camera.sensor,
        distance=camera.distance,
        focal=camera.focal,
        noise_mm=camera.noise_mm,
        seed=camera.seed,
        threads=camera.threads,
    )


def record(circle: Circle, folder: Path, camera: Camera) -> Recorded:
    """Record a circle as FOLDER/NAME.mcap, unless it is there.

    Raises UnwritableOutput where what is there is another recording, UnreadableRecording where it is none.
    """
    path = folder / f"{circle.name}.mcap"
    session = open_circle(circle, camera)
    kept = path.exists()
    if not kept:
        mcap_file.write(session, path)
    elif mcap_file.read(path).info != session.info:
        raise UnwritableOutput(path, "was recorded with other options", "remove it, or choose another place with -o")
    return Recorded(path, session.info.views, kept)


def record_all(circles: Sequence[Circle], folder: Path, camera: Camera, workers: int = 1) -> Iterator[Recorded]:
    """A Recorded for each circle as it is ready; with several workers in the order they finish.

    What is finished stays when it is interrupted. Raises what `record` raises, and InvalidOption for a folder whose
    name ends in .mcap.
    """
    if folder.suffix == ".mcap":
        raise InvalidOption(
            f"-o {folder}", f"{len(circles)} recordings do not fit one file", "give a folder, such as -o corpus"
        )
    if workers == 1:
        yield from (record(circle, folder, camera) for circle in circles)
        return
    camera = replace(camera, threads=max(1, (cpu_count() or 1) // workers))
    # spawn: forked children hang in libraries that had already started threads
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        try:
            pending = [pool.submit(record, circle, folder, camera) for circle in circles]
            yield from (future.result() for future in as_completed(pending))
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
