"""The command `view`: results or a recording in the viewer, or as a picture."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

import typer

from orbitscan.recorder.exceptions import InvalidOption, ScanError, setting

SHOWN_SESSIONS = 8  # of a batch that `view` opens, a few hundred megabytes at most
_SIGNALLED = 128  # added to the number of a signal that ended the viewer, as a shell does


def view(
    what: Annotated[
        Path, typer.Argument(help="Results of a session or a batch, a Rerun recording (.rrd), or a recording (.mcap).")
    ],
    most: Annotated[int, typer.Option("--most", min=1, help="Sessions of a batch, worst first.")] = SHOWN_SESSIONS,
    screenshot: Annotated[
        Path | None, typer.Option(metavar="OUT.png", help="Save a picture instead; needs no display.")
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Of the picture.")] = "1920x1080",
    at: Annotated[int | None, typer.Option(min=0, metavar="VIEW", help="The picture's cursor is at this view.")] = None,
) -> None:
    """Open results or a recording in the Rerun viewer, or save a picture of them.

    Of a batch its summary and the worst sessions: those with the most views that failed, then with the largest errors.

    \b
    Examples:
      orbitscan view results/bunny
      orbitscan view results/ --most 20
      orbitscan view results/bunny --screenshot bunny.png --at 7
    """
    files, left_out = choose_files(what, most)
    if screenshot is not None:
        _save_picture(files[0], screenshot, size, at)
        return
    if at is not None:
        raise InvalidOption(setting("at", at), "is for pictures", "add --screenshot OUT.png, or leave it out")
    if left_out:
        sessions = "session is" if left_out == 1 else "sessions are"
        typer.echo(f"{left_out} better {sessions} left out: --most {most + left_out} opens all, or name one.")
    import subprocess

    from orbitscan.processing.review.screenshot import find_viewer

    # The viewer shows the last one that it is given, and lists all.
    status = subprocess.call([str(find_viewer()), *(str(file) for file in reversed(files))])
    raise typer.Exit(status if status >= 0 else _SIGNALLED - status)


def choose_files(what: Path, most: int) -> tuple[list[Path], int]:
    """What the viewer opens, the first thing to look at first, and how many of a batch's sessions are left out.

    Raises InvalidOption where there is nothing.
    """
    if what.is_file():
        if what.suffix.lower() not in (".rrd", ".mcap"):
            raise InvalidOption(what, "the viewer does not open it", "name a results folder, a .rrd or a .mcap")
        return [what], 0
    if (what / "review.rrd").is_file():
        return [what / "review.rrd"], 0
    summary = [what / "summary.rrd"] if (what / "summary.rrd").is_file() else []
    rest = [path for path in sorted(what.glob("*.rrd")) if path not in summary]
    sessions = [path.parent for path in what.glob("*/review.rrd") if path.parent.suffix != ".part"]
    worst = _order(sessions)
    files = [*summary, *(folder / "review.rrd" for folder in worst[:most]), *rest]
    if not files:
        problem = "holds no .rrd" if what.is_dir() else "no such file or folder"
        raise InvalidOption(what, problem, "name a results folder, a .rrd or a .mcap")
    return files, max(0, len(worst) - most)


def _order(folders: Iterable[Path]) -> list[Path]:
    """Results, worst first; what cannot be read is before all."""
    from orbitscan.processing.results.batch_table import Row, read_row, worst_first

    def read(folder: Path) -> Row:
        try:
            return read_row(folder)
        except ScanError:
            return Row(folder.name, "failed")

    by_name = {folder.name: folder for folder in folders}
    return [by_name[row.session] for row in worst_first([read(folder) for folder in by_name.values()])]


def _save_picture(recording: Path, picture: Path, size: str, at: int | None) -> None:
    from orbitscan.processing.review.screenshot import take_picture

    sides = size.split("x")
    if len(sides) != 2 or not all(side.isdigit() and 200 <= int(side) <= 8000 for side in sides):
        remedy = "give pixels from 200 to 8000, such as 1920x1080"
        raise InvalidOption(setting("size", size), "not the size of a picture", remedy)
    reports = take_picture(recording, picture, size, at)
    where = "as it opens" if at is None else f"at view {at}"
    typer.echo(f"{picture}: {recording} {where}; " + ("no view complains." if not reports else "views complain:"))
    for report in reports:
        typer.echo(f"  {report}", err=True)
