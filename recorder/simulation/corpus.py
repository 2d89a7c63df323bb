"""The thesis's data from virtual objects: every instance on its circles, at three camera heights, before a Kinect."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from os import cpu_count
from pathlib import Path

from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import InvalidOption, UnwritableOutput, Wording, setting
from orbitscan.recorder.session import Session
from orbitscan.recorder.simulation.camera import Camera, simulate
from orbitscan.recorder.sources.washington import ELEVATIONS_DEG, RUNS
from orbitscan.recorder.sources.washington import INSTANCES as INSTANCES  # of the corpus, which has as many
from orbitscan.recorder.workers import as_ready

OTHER_INSTANCES = 3  # of every other thing
CAMERA = Camera(views=200, sensor="kinect")  # of every circle


@dataclass(frozen=True)
class Circle:
    """One turn around one instance of a category."""

    category: str
    instance: int
    video: int

    @property
    def name(self) -> str:
        """The circle's name, as the Washington dataset would name it."""
        return f"{self.category}_{self.instance}_{self.video}"

    @property
    def start_deg(self) -> float:
        """The azimuth of the first view, half a run before the front: a run shows the same side of every instance."""
        return -180 / RUNS.get(self.category, 1)


@dataclass(frozen=True)
class Recorded:
    """What `record` made of a circle."""

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
    camera = replace(camera, elevation_deg=ELEVATIONS_DEG[circle.video], start_deg=circle.start_deg)
    return simulate(circle.category, circle.instance, camera, name=circle.name)


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
        raise UnwritableOutput(path, "was recorded with other options", Wording("remove it, or choose another {place}"))
    return Recorded(path, session.info.views, kept)


def record_all(circles: Sequence[Circle], folder: Path, camera: Camera, workers: int = 1) -> Iterator[Recorded]:
    """A Recorded for each circle as it is ready; with several workers in the order they finish.

    What is finished stays when it is interrupted. Raises what `record` raises, and InvalidOption for a folder whose
    name ends in .mcap.
    """
    if folder.suffix == ".mcap":
        problem = f"{len(circles)} recordings do not fit one file"
        raise InvalidOption(setting("folder", folder), problem, "give a folder, such as 'corpus'")
    if workers == 1:
        yield from (record(circle, folder, camera) for circle in circles)
        return
    camera = replace(camera, threads=max(1, (cpu_count() or 1) // workers))
    for _, recorded in as_ready(partial(record, folder=folder, camera=camera), circles, workers):
        yield recorded.result()
