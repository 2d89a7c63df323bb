"""The command `view`."""

from pathlib import Path
from typing import Annotated

import typer

from recorder.exceptions import InvalidOption


def view(
    what: Annotated[Path, typer.Argument(help="A results folder, a review (.rrd) or a recording (.mcap).")],
) -> None:
    """Open results or a recording in the Rerun viewer.

    orbitscan view results/bunny
    """
    import subprocess

    files = _files_to_view(what)
    try:
        raise typer.Exit(subprocess.call(["rerun", *map(str, files)]))
    except FileNotFoundError:
        raise InvalidOption("rerun", "the viewer is not on the PATH", "activate the environment of orbitscan") from None


def mount(app: typer.Typer) -> None:
    """Add the commands to an application."""
    app.command()(view)


def _files_to_view(what: Path) -> list[Path]:
    if what.is_file():
        return [what]
    reviews = [what / "review.rrd"] if (what / "review.rrd").is_file() else sorted(what.glob("*/review.rrd"))
    if not reviews:
        raise InvalidOption(what, "holds no review.rrd", "name a results folder, a .rrd or a .mcap")
    return reviews
