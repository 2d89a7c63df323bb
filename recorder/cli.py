"""The recorder's commands: convert, simulate, info, check. Each parses, calls the library and prints."""

import os
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn, TypeVar

import typer

from orbitscan.recorder.console import counter, progress
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose, ScanError, UnreadableCloud

if TYPE_CHECKING:
    from orbitscan.recorder.check import Finding
    from orbitscan.recorder.session import Session, SessionInfo, View

Item = TypeVar("Item")
INFO_VIEWS = "9"  # views that `info` measures


class Format(StrEnum):
    """The formats of a capture."""

    CLOUDS = "clouds"
    STANFORD = "stanford"
    WASHINGTON = "washington"


class Direction(StrEnum):
    """What a pose maps to what."""

    CAMERA_TO_OBJECT = "camera-to-object"
    OBJECT_TO_CAMERA = "object-to-camera"


class Unit(StrEnum):
    """Units of length."""

    METRE = "m"
    CENTIMETRE = "cm"
    MILLIMETRE = "mm"


class Sensor(StrEnum):
    """The depth sensors of the virtual camera."""

    GAUSSIAN = "gaussian"
    KINECT = "kinect"


Output = Annotated[Path, typer.Option("-o", "--output", help="A recording X.mcap, or a folder for NAME.mcap.")]
Recording = Annotated[Path, typer.Argument(help="A recording (.mcap).", metavar="SESSION.mcap", show_default=False)]


def convert(
    source: Annotated[Path, typer.Argument(help="A folder of clouds, a cloud, a .conf.", show_default=False)],
    output: Output,
    format: Annotated[Format | None, typer.Option(help="Else recognised from the content.")] = None,
    poses: Annotated[
        Path | None, typer.Option(help="True poses: TUM, KITTI, 4x4 or JSON. Else the file that lies with the clouds.")
    ] = None,
    poses_are: Annotated[Direction | None, typer.Option(help="Default: camera-to-object.")] = None,
    units: Annotated[Unit | None, typer.Option(help="Of the points and the poses. Default: m.")] = None,
    pose_units: Annotated[Unit | None, typer.Option(help="Of the poses, where they differ.")] = None,
    scale: Annotated[float | None, typer.Option(help="Times the units, in points and poses.")] = None,
    axes: Annotated[
        str | None, typer.Option(help="Where x, y, z of a cloud point: RDF (default), RUB, RFU, FLU, ...")
    ] = None,
    pose_axes: Annotated[str | None, typer.Option(help="The camera axes of the poses, where they differ.")] = None,
    sensor_origin: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z|unknown", help="The sensor in a cloud's own units and axes. Default: 0,0,0."),
    ] = None,
    columns: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z", help="Which named columns of a text file are x, y, z. Else recognised."),
    ] = None,
    category: Annotated[str | None, typer.Option(help="What the object is, such as coffee_mug.")] = None,
    instance: Annotated[str | None, typer.Option(help="Which one of its category.")] = None,
    elevation: Annotated[
        float | None, typer.Option(help="Degrees that the camera looks down; 0 where the frame is level.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="The session's name. Default: that of the output or source.")] = None,
    categories_from_folders: Annotated[
        bool,
        typer.Option(
            "--categories-from-folders",
            help="SOURCE is a folder of folders named by category; each cloud below becomes a recording.",
        ),
    ] = False,
) -> None:
    """Convert captured scans into recordings, one per session.

    Reads folders of PLY, PCD, XYZ, CSV and NPY clouds, Stanford .conf files and trees of the Washington RGB-D dataset.
    What would spoil the processing is told, wrong poses first of all; then the exit status is 1.

    \b
    Examples:
      orbitscan convert scans/ -o mug.mcap
      orbitscan convert scans/ -o mug.mcap --poses poses.tum --units mm
      orbitscan convert bunny/bun.conf -o bunny.mcap
      orbitscan convert rgbd-dataset/ -o recordings/
      orbitscan convert lidar/ -o recordings/ --categories-from-folders --axes LUF --scale 0.2
    """
    from orbitscan.recorder import mcap_file
    from orbitscan.recorder.check import check as find
    from orbitscan.recorder.sources import open_capture
    from orbitscan.recorder.sources.options import CaptureOptions

    options = CaptureOptions(
        format=format,
        poses=poses,
        poses_are=poses_are,
        units=units,
        pose_units=pose_units,
        scale=scale,
        axes=axes,
        pose_axes=pose_axes,
        sensor_origin=_parse_origin(sensor_origin),
        columns=parse_columns(columns),
        category=category,
        instance=instance,
        elevation=elevation,
        name=name,
        categories_from_folders=categories_from_folders or None,
    )
    sessions = open_capture(source, options)
    if output.suffix == ".mcap" and len(sessions) > 1:
        raise InvalidOption(
            f"-o {output}", f"{source} holds {len(sessions)} sessions", "give a folder, such as -o recordings"
        )
    if categories_from_folders:
        failed = _record_collection(sessions, output)
        print(f"next: orbitscan train {output} -o model.pt")
        raise typer.Exit(1 if failed else 0)
    failed = False
    for session in sessions:
        path, session = _place(session, output, name)
        try:
            _write(session, path)
        except (UnreadableCloud, InvalidPose) as error:
            if len(sessions) == 1:
                raise
            failed = True
            _complain(error)
            continue
        for finding in find(mcap_file.read(path)):
            failed |= finding.severity == "problem"
            if finding.severity == "problem" or session.truth():
                print(f"  {finding}")
    _tell_next(output)
    raise typer.Exit(1 if failed else 0)


def simulate(
    what: Annotated[
        str,
        typer.Argument(
            metavar="OBJECT|MESH|corpus|others",
            help="robot, bin, statue, helicopter, vacuum_cleaner, apple, bell_pepper, bowl, cap, cell_phone, "
            "coffee_mug, dry_battery, notebook, pliers, water_bottle, other things such as banana or keyboard, "
            "or a mesh file; corpus: all instances of the thesis's ten categories; others: other things.",
        ),
    ],
    output: Output,
    instance: Annotated[int | None, typer.Option(help="Which one of the objects of this name. Default: 1.")] = None,
    instances: Annotated[int | None, typer.Option(help="Of each category of a corpus. Default: the thesis's.")] = None,
    views: Annotated[int | None, typer.Option(help="Views in one turn. Default: 18; of a corpus 200.")] = None,
    every: Annotated[int, typer.Option(help="Record only each so many-th of these views.")] = 1,
    elevation: Annotated[
        float | None,
        typer.Option(help="Of the camera above the object, in degrees. Default: 30; of a corpus 30, 45 and 60."),
    ] = None,
    sensor: Annotated[Sensor | None, typer.Option(help="Default: gaussian; of a corpus kinect.")] = None,
    distance: Annotated[
        float | None,
        typer.Option(help="Of the camera, in metres. Default: 1 (kinect 0.72), or 2.5 radii of a large object."),
    ] = None,
    focal: Annotated[float | None, typer.Option(help="Focal length, in pixels. Default: 525 (kinect 570).")] = None,
    noise_mm: Annotated[
        float, typer.Option(help="Standard deviation of the depth at 1 m; grows with its square.")
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Of the noise.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Circles of a corpus recorded at the same time.")] = 1,
) -> None:
    """Scan an object or a mesh (metres) with a virtual depth camera; the poses are exact.

    A corpus is a folder of such circles, of many objects from three heights; finished ones are kept when it is started
    again.

    \b
    Examples:
      orbitscan simulate robot -o robot.mcap
      orbitscan simulate cup.stl -o cup.mcap --views 36 --noise-mm 2
      orbitscan simulate coffee_mug -o mug.mcap --sensor kinect
      orbitscan simulate corpus -o corpus/ --every 10 --workers 4
    """
    from orbitscan.recorder.session import DEFAULT_VIEWS
    from orbitscan.recorder.simulation import camera

    options = {"every": every, "distance": distance, "focal": focal, "noise_mm": noise_mm, "seed": seed}
    if what in ("corpus", "others"):
        for option, value in (("--instance", instance), ("--elevation", elevation)):
            if value is not None:
                raise InvalidOption(f"{option} {value:g}", f"is not for {what}", "leave it out, or name one object")
        _record_corpus(what, output, instances, workers, views, sensor or Sensor.KINECT, options)
        return
    if instances is not None:
        raise InvalidOption(f"--instances {instances}", f"is not for {what}", "name 'corpus', or use --instance")
    session = camera.simulate(
        what,
        instance=1 if instance is None else instance,
        views=DEFAULT_VIEWS if views is None else views,
        elevation_deg=30.0 if elevation is None else elevation,
        sensor=sensor or Sensor.GAUSSIAN,
        **options,
    )
    path, session = _place(session, output, None)
    _write(session, path)
    _tell_next(output)


def _record_corpus(
    what: str,
    folder: Path,
    instances: int | None,
    workers: int,
    views: int | None,
    sensor: "Sensor",
    options: dict[str, Any],
) -> None:
    from orbitscan.recorder.simulation import corpus, objects

    if instances is not None and instances < 1:
        raise InvalidOption(f"--instances {instances}", "a category has at least one", "give 1 or more")
    table = corpus.INSTANCES if what == "corpus" else dict.fromkeys(objects.OTHERS, corpus.OTHER_INSTANCES)
    circles = corpus.plan({name: instances or count for name, count in table.items()})
    camera = corpus.Camera(views=corpus.DEFAULT_VIEWS if views is None else views, sensor=sensor, **options)
    recorded = list(progress(corpus.record_all(circles, folder, camera, workers), len(circles), "Recording"))
    kept = sum(circle.kept for circle in recorded)
    total = sum(circle.views for circle in recorded)
    print(f"{folder}: {len(recorded)} recordings, {total:,} views" + (f"; {kept} were there already" if kept else ""))
    print(f"next: orbitscan train {folder} -o model.pt")


def info(recording: Recording) -> None:
    """Tell what a recording holds: views, poses, sizes, resolution, noise.

    \b
    Example:
      orbitscan info mug.mcap
    """
    import numpy as np

    from orbitscan.recorder import cloud, mcap_file
    from orbitscan.recorder.check import length, name_views
    from orbitscan.recorder.session import DEFAULT_VIEWS, select_views

    session = mcap_file.read(recording)
    facts = session.info
    measured = [cloud.measure(cloud.finite(view.points)[0]) for view in session.views(INFO_VIEWS)]
    measured = [fact for fact in measured if fact.points > 1]
    points, unreadable = [], []
    for view in session.views():
        points.append(len(cloud.finite(view.points)[0]))
        if view.damage:
            unreadable.append(view.index)
    damage = [session.damage] if session.damage else []
    damage += [f"{name_views(unreadable)} unreadable"] if unreadable else []
    used = select_views(str(DEFAULT_VIEWS), session.names)
    try:
        known = f"{len(session.truth())} of {facts.views}" + (f" ({facts.source_poses})" if facts.has_estimates else "")
    except InvalidPose as error:
        known = f"unreadable ({error.problem})"

    def median(of: Callable) -> float:
        return float(np.median([of(fact) for fact in measured])) if measured else float("nan")

    sides = " x ".join(f"{100 * median(lambda fact, i=i: fact.extent[i]):.1f}" for i in range(3))
    rows = {
        "name": facts.name,
        "category": " ".join(filter(None, (facts.category, facts.instance))) or "unknown",
        "source": ", ".join(filter(None, (facts.source, facts.sensor, f"capture {facts.capture}"))),
        "views": f"{facts.views} ({session.names[0]} ... {session.names[-1]})",
        "poses known": known,
        "extent": f"{sides} cm (width, height, depth of a view)",
        "distance": length(median(lambda fact: fact.distance)),
        "points": f"{min(points):,} / {int(np.median(points)):,} / {max(points):,} a view (least, median, most)",
        "resolution": f"{1000 * median(lambda fact: fact.resolution):.2f} mm",
        "noise": f"{1000 * median(lambda fact: fact.noise):.2f} mm",
        f"--views {DEFAULT_VIEWS}": "all" if len(used) == facts.views else " ".join(map(str, used)),
        "damage": "; ".join(damage) or "none",
    }
    for key, value in rows.items():
        print(f"{key:<12} {value}")


def check(recording: Recording) -> None:
    """Look for what would spoil the processing of a recording; exit status 1 where there is a problem.

    \b
    Example:
      orbitscan check mug.mcap
    """
    from orbitscan.recorder import mcap_file
    from orbitscan.recorder.check import check as find

    findings = find(mcap_file.read(recording))
    for finding in findings:
        print(finding)
    if any(finding.severity == "problem" for finding in findings):
        raise typer.Exit(1)
    print(f"next: orbitscan process {recording} -o results")


def mount(app: typer.Typer) -> None:
    """Add the recorder's commands to an application."""
    for command in (convert, simulate, info, check):
        app.command()(command)


def run(app: typer.Typer, arguments: Sequence[str] | None = None) -> NoReturn:
    """Run a command line and exit; a ScanError is told in one line on stderr, and is status 2."""
    try:
        app(args=arguments, prog_name="orbitscan")
    except ScanError as error:
        _complain(error)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:
        sys.exit(1)
    finally:
        _flush()
    sys.exit(0)


def _flush() -> None:
    """Write out what was printed; where nobody reads any more, the interpreter's own last flush shall not complain."""
    try:
        if sys.__stdout__ is not None:
            sys.__stdout__.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())


def _place(session: "Session", output: Path, name: str | None) -> tuple[Path, "Session"]:
    """Where a session is written and what it is called there: as the file, where the user named one."""
    if name is not None and Path(name).name != name:
        raise InvalidOption(f"--name {name}", "no name for a file", "give one without slashes")
    if output.suffix == ".mcap":
        return output, replace(session, info=replace(session.info, name=name or output.stem))
    return output / f"{session.info.name}.mcap", session


def _write(session: "Session", path: Path) -> None:
    from orbitscan.recorder import mcap_file

    with counter(len(session.names), path.name) as advance:

        def load(index: int) -> object:
            advance()
            return session.load(index)

        mcap_file.write(replace(session, load=load), path)
    count = len(session.names)
    print(f"{path}: {count} view{'s' if count != 1 else ''}")


def _record_collection(sessions: Sequence["Session"], output: Path) -> bool:
    """Whether something failed; prints what did, how many each category has, and which option mends them all."""
    from orbitscan.recorder import mcap_file

    recorded = []
    for session in progress(sessions, len(sessions), "Converting"):
        path, session = _place(session, output, None)
        try:
            mcap_file.write(session, path)
        except UnreadableCloud as error:
            _complain(error)
            continue
        recorded.append((path, session.info))
    counts = sorted(Counter(info.category for _, info in recorded).items())
    each = ", ".join(f"{category} {count}" for category, count in counts)
    print(f"{output}: {len(recorded)} recordings" + (f" ({each})" if each else ""))
    findings = _check_as_one(recorded)
    for finding in findings:
        print(f"  {finding}")
    return len(recorded) < len(sessions) or bool(findings)


def _check_as_one(recorded: Sequence[tuple[Path, "SessionInfo"]]) -> list["Finding"]:
    """What an option of `convert` would mend in recordings of a view each: axes and sizes are those of most."""
    from orbitscan.recorder import mcap_file
    from orbitscan.recorder.check import check as find
    from orbitscan.recorder.session import Session

    if not recorded:
        return []

    def load(index: int) -> "View":
        return replace(mcap_file.read(recorded[index][0]).load(0), index=index)

    names = tuple(info.name for _, info in recorded)
    findings = find(Session(replace(recorded[0][1], views=len(names)), names, load))
    return [finding for finding in findings if finding.severity == "problem" and "--" in finding.remedy]


def parse_columns(text: str | None) -> tuple[str, str, str] | None:
    """The three names of `--columns`. Raises InvalidOption."""
    if text is None:
        return None
    names = [name.strip() for name in text.split(",")]
    if len(set(names)) != 3 or len(names) != 3 or "" in names:
        raise InvalidOption(f"--columns {text}", "no three names", "write those of x, y and z, such as px,py,pz")
    return names[0], names[1], names[2]


def _parse_origin(text: str | None) -> tuple[float, float, float] | Literal["unknown"] | None:
    if text is None or text == "unknown":
        return text
    try:
        x, y, z = (float(word) for word in text.split(","))
    except ValueError:
        raise InvalidOption(f"--sensor-origin {text}", "neither X,Y,Z nor 'unknown'", "write 0,0,0") from None
    return x, y, z


def _tell_next(output: Path) -> None:
    if output.suffix == ".mcap":
        print(f"next: orbitscan check {output}")
    print(f"next: orbitscan process {output} -o results")


def _complain(error: ScanError) -> None:
    print(f"orbitscan: error: {error}", file=sys.stderr)
