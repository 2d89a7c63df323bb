"""The commands that look at results: `view` and `compare`."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbitscan.recorder.exceptions import InvalidOption

if TYPE_CHECKING:
    from orbitscan.processing.results.comparison.records import Comparison

SHOWN_SESSIONS = 8  # of a batch that `view` opens, a few hundred megabytes at most
SHOWN_ROWS = 20  # of a table that `compare` prints
SHOWN_OF_EACH = 3  # views of each session of a batch
_COLORS = {"worse": "red", "changed": "yellow", "better": "green"}
_NARROW = ("view", "method", "verdict", "floors")  # columns that do not wrap
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
        raise InvalidOption(f"--at {at}", "is for pictures", "add --screenshot OUT.png, or leave it out")
    if left_out:
        sessions = "session is" if left_out == 1 else "sessions are"
        typer.echo(f"{left_out} less bad {sessions} left out: --most {most + left_out} opens all, or name one.")
    import subprocess

    from orbitscan.processing.review.screenshot import find_viewer

    # The viewer shows the last one that it is given, and lists all.
    status = subprocess.call([str(find_viewer()), *(str(file) for file in reversed(files))])
    raise typer.Exit(status if status >= 0 else _SIGNALLED - status)


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="Results of a session or a batch: the old ones.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="Results of the same: the new ones.")],
    rrd: Annotated[
        Path | None, typer.Option(metavar="OUT.rrd", help="Write both side by side as a Rerun recording.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Compare two results: what changed, by how much, and whether B is worse by more than chance.

    Sessions of batches are matched by name. An error changed where it did so by more than the views' own evidence can
    tell; a status or a category, where it is another one. Exit status 1: B is worse somewhere, or lacks a session of A.

    \b
    Examples:
      orbitscan compare before/ after/
      orbitscan compare before/bunny after/bunny --rrd bunny.rrd
    """
    from orbitscan.processing.results.comparison.compare import compare_folders
    from orbitscan.processing.review.comparison.words import conclude

    found = compare_folders(a, b)
    if rrd is not None:  # first: whoever reads what is printed may stop reading
        from orbitscan.processing.review.comparison.recording import write_comparison

        write_comparison(rrd, found, a, b)
    if as_json:
        typer.echo(json.dumps({"verdict": conclude(found), "is_worse": found.is_worse, **_to_json(found)}, indent=1))
    else:
        typer.echo(conclude(found))
        _print_changes(found)
    if rrd is not None:
        typer.echo(f"Look at it: orbitscan view {rrd}", err=as_json)
    raise typer.Exit(int(found.is_worse))


def mount(app: typer.Typer) -> None:
    """Add the commands to an application."""
    for command in (compare, view):
        app.command()(command)


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
            row = read_row(folder)
            worst_first([row])  # it has what the order asks for
            return row
        except (OSError, ValueError, KeyError, TypeError):
            return Row(folder.name, "failed")

    by_name = {folder.name: folder for folder in folders}
    return [by_name[row.session] for row in worst_first([read(folder) for folder in by_name.values()])]


def _save_picture(recording: Path, picture: Path, size: str, at: int | None) -> None:
    from orbitscan.processing.review.screenshot import take_picture

    sides = size.split("x")
    if len(sides) != 2 or not all(side.isdigit() and 200 <= int(side) <= 8000 for side in sides):
        raise InvalidOption(f"--size {size}", "no size of a picture", "give pixels from 200 to 8000, such as 1920x1080")
    reports = take_picture(recording, picture, size, at)
    where = "as it opens" if at is None else f"at view {at}"
    typer.echo(f"{picture}: {recording} {where}; " + ("no view complains." if not reports else "views complain:"))
    for report in reports:
        typer.echo(f"  {report}", err=True)


def _print_changes(found: Comparison) -> None:
    """What else differs, the sessions of a batch, and the views that changed, worst first."""
    from orbitscan.processing.review.comparison.words import (
        BRIEF_HEADER,
        METHOD_HEADER,
        SESSION_HEADER,
        brief_rows,
        list_notes,
        method_rows,
        session_rows,
    )

    for note in list_notes(found.sessions):
        typer.echo(f"- {note}")
    batch = len(found.sessions) > 1
    if batch:
        changed = [session for session in found.sessions if session.verdict != "same"]
        _print_table(
            "Sessions that changed, A → B by the best method", SESSION_HEADER, session_rows(changed), len(changed)
        )
    elif not found.sessions[0].identical:
        rows = method_rows(found.sessions[0])
        _print_table("Methods, A → B", METHOD_HEADER, rows, len(rows))
    header = ("session", *BRIEF_HEADER) if batch else BRIEF_HEADER
    most = SHOWN_OF_EACH if batch else SHOWN_ROWS
    rows = [
        (session.name, *row) if batch else row
        for session in found.sessions
        for row in brief_rows(session.changed_views[:most])
    ]
    total = sum(len(session.changed_views) for session in found.sessions)
    _print_table("Views that changed, worst first, A → B", header, rows, total)
    if rows:
        typer.echo("floors: the change over what may be chance, as the views' own evidence tells")


def _print_table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]], total: int) -> None:
    """The first rows, and how many of `total` are not shown."""
    from rich.text import Text

    from orbitscan.recorder.console import print_table

    columns = {name: {"overflow": "fold", "no_wrap": name in _NARROW} for name in header}
    cells = [[Text(cell, style=_COLORS.get(cell, "")) for cell in row] for row in rows[:SHOWN_ROWS]]
    print_table(title, columns, cells)
    if total > len(cells):
        typer.echo(f"and {total - len(cells)} more: --json lists them all")


def _to_json(value: Any) -> Any:
    """Records as JSON has them; an infinite size (a change of status has none) is null."""
    from dataclasses import fields, is_dataclass

    if is_dataclass(value):
        known = {field.name: _to_json(getattr(value, field.name)) for field in fields(value)}
        return known | ({"verdict": value.verdict} if hasattr(value, "verdict") else {})
    if isinstance(value, dict):
        return {str(key): _to_json(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_to_json(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
