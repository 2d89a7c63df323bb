"""Where a recording is written, and what is told of it."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitscan.recorder.console import counter
from orbitscan.recorder.exceptions import InvalidOption, ScanError, Values, setting

if TYPE_CHECKING:
    from orbitscan.recorder.session import Session, View

Output = Annotated[Path, typer.Option("-o", "--output", help="A recording X.mcap, or a folder for NAME.mcap.")]
_FLAGS = {  # settings whose option has another name
    "folder": "-o",
    "results": "-o",
    "place": "place with -o",
    "elevation_deg": "--elevation",
}


def as_flags(settings: Values) -> str:
    """Settings as the command line writes them: `--units mm --columns px,py,pz --live`."""
    return " ".join(_flag(_FLAGS.get(name, f"--{name.replace('_', '-')}"), value) for name, value in settings.items())


def _flag(flag: str, value: Any) -> str:
    if value is None or value is True:
        return flag
    if isinstance(value, float):
        return f"{flag} {value:g}"
    return f"{flag} {','.join(map(str, value)) if isinstance(value, tuple) else value}"


def place(session: "Session", output: Path, name: str | None) -> tuple[Path, "Session"]:
    """Where a session is written and what it is called there: as the file, where the user named one."""
    if name is not None and Path(name).name != name:
        raise InvalidOption(setting("name", name), "not a file name", "give one without slashes")
    if output.suffix == ".mcap":
        return output, replace(session, info=replace(session.info, name=name or output.stem))
    return output / f"{session.info.name}.mcap", session


def write(session: "Session", path: Path) -> None:
    from orbitscan.recorder import mcap_file

    with counter(len(session.names), path.name) as advance:

        def load(index: int) -> "View":
            advance()
            return session.load(index)

        mcap_file.write(replace(session, load=load), path)
    count = len(session.names)
    print(f"{path}: {count} view{'s' if count != 1 else ''}")


def tell_next(output: Path) -> None:
    if output.suffix == ".mcap":
        print(f"next: orbitscan check {output}")
    print(f"next: orbitscan process {output} -o results")


def complain(error: ScanError) -> None:
    print(f"orbitscan: error: {error.spelled(as_flags)}", file=sys.stderr)
