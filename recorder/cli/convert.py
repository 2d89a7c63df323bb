"""The command `convert`: captures to recordings."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitscan.recorder.cli.output import Output, as_flags, complain, place, tell_next, write
from orbitscan.recorder.console import progress
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose, UnreadableCloud, setting

if TYPE_CHECKING:
    from orbitscan.recorder.session import Session


Format = Literal["clouds", "stanford", "washington"]
Direction = Literal["camera-to-object", "object-to-camera"]
Unit = Literal["m", "cm", "mm"]


def convert(
    source: Annotated[Path, typer.Argument(help="A folder of clouds, a cloud, a .conf.", show_default=False)],
    output: Output,
    format: Annotated[Format | None, typer.Option(help="By default recognised from the content.")] = None,
    poses: Annotated[
        Path | None, typer.Option(help="True poses: TUM, KITTI, 4x4 or JSON. Default: the file beside the clouds.")
    ] = None,
    poses_are: Annotated[Direction | None, typer.Option(help="Default: camera-to-object.")] = None,
    units: Annotated[Unit | None, typer.Option(help="Units of the points and the poses. Default: m.")] = None,
    pose_units: Annotated[Unit | None, typer.Option(help="Units of the poses, where they differ.")] = None,
    scale: Annotated[float | None, typer.Option(help="A factor besides the units, of points and poses.")] = None,
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
        typer.Option(metavar="X,Y,Z", help="Which named columns of a text file are x, y, z. By default recognised."),
    ] = None,
    category: Annotated[str | None, typer.Option(help="What the object is, such as coffee_mug.")] = None,
    instance: Annotated[str | None, typer.Option(help="Which instance of its category it is.")] = None,
    elevation: Annotated[
        float | None, typer.Option(help="How many degrees the camera looks down; 0 where its frame is level.")
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
    said: dict[str, Any] = dict(locals())  # the options by their names, most of them those of CaptureOptions
    from orbitscan.recorder import mcap_file
    from orbitscan.recorder.check import check as find
    from orbitscan.recorder.conversion import CaptureOptions
    from orbitscan.recorder.sources import open_capture

    said |= {"sensor_origin": _parse_origin(sensor_origin), "columns": parse_columns(columns)}
    said |= {"categories_from_folders": categories_from_folders or None}
    options = CaptureOptions(**{field.name: said[field.name] for field in fields(CaptureOptions)})
    sessions = open_capture(source, options)
    if output.suffix == ".mcap" and len(sessions) > 1:
        problem = f"{source} holds {len(sessions)} sessions"
        raise InvalidOption(setting("folder", output), problem, "give a folder, such as -o recordings")
    if categories_from_folders:
        failed = _record_collection(sessions, output)
        print(f"next: orbitscan train {output} -o model.pt")
        raise typer.Exit(1 if failed else 0)
    failed = False
    for path, session in (place(session, output, name) for session in sessions):
        try:
            write(session, path)
        except (UnreadableCloud, InvalidPose) as error:
            if len(sessions) == 1:
                raise
            failed = True
            complain(error)
            continue
        for finding in find(mcap_file.read(path)):
            failed |= finding.severity == "problem"
            if finding.severity == "problem" or session.truth():
                print(f"  {finding.spelled(as_flags)}")
    tell_next(output)
    raise typer.Exit(1 if failed else 0)


def _record_collection(sessions: Sequence["Session"], output: Path) -> bool:
    """Whether something failed; prints what did, how many each category has, and which settings mend them all."""
    from orbitscan.recorder.check import check_together
    from orbitscan.recorder.sources.category_folders import record

    recorded = []
    placed = (place(session, output, None) for session in sessions)
    for result in progress(record(placed), len(sessions), "Converting"):
        if isinstance(result, UnreadableCloud):
            complain(result)
        else:
            recorded.append(result)
    counts = sorted(Counter(session.info.category for session in recorded).items())
    each = ", ".join(f"{category} {count}" for category, count in counts)
    print(f"{output}: {len(recorded)} recordings" + (f" ({each})" if each else ""))
    findings = check_together(recorded)
    for finding in findings:
        print(f"  {finding.spelled(as_flags)}")
    return len(recorded) < len(sessions) or bool(findings)


def parse_columns(text: str | None) -> tuple[str, str, str] | None:
    """The three names of columns in a text with commas; None for None. Raises InvalidOption."""
    if text is None:
        return None
    names = [name.strip() for name in text.split(",")]
    if len(set(names)) != 3 or len(names) != 3 or "" in names:
        raise InvalidOption(setting("columns", text), "not three names", "write those of x, y and z, such as px,py,pz")
    return names[0], names[1], names[2]


def _parse_origin(text: str | None) -> tuple[float, float, float] | Literal["unknown"] | None:
    if text is None:
        return None
    if text == "unknown":
        return "unknown"
    try:
        x, y, z = (float(word) for word in text.split(","))
    except ValueError:
        raise InvalidOption(setting("sensor_origin", text), "neither X,Y,Z nor 'unknown'", "write 0,0,0") from None
    return x, y, z
