"""The command `compare`: what changed from one result to another."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from orbitscan.processing.results.comparison.records import Comparison

SHOWN_ROWS = 20  # of a table
SHOWN_OF_EACH = 3  # views of each session of a batch
_COLORS = {"worse": "red", "changed": "yellow", "better": "green"}
_NARROW = ("view", "method", "verdict", "floors")  # columns that do not wrap


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


def _print_changes(found: Comparison) -> None:
    """What else differs, the sessions of a batch, and the views that changed, worst first."""
    from orbitscan.processing.review.comparison import words

    for note in words.list_notes(found.sessions):
        typer.echo(f"- {note}")
    batch = len(found.sessions) > 1
    if batch:
        changed = [session for session in found.sessions if session.verdict != "same"]
        title = "Sessions that changed, A → B by the best method"
        _print_table(title, words.SESSION_HEADER, words.session_rows(changed), len(changed))
    elif not found.sessions[0].identical:
        rows = words.method_rows(found.sessions[0])
        _print_table("Methods, A → B", words.METHOD_HEADER, rows, len(rows))
    header = ("session", *words.BRIEF_HEADER) if batch else words.BRIEF_HEADER
    most = SHOWN_OF_EACH if batch else SHOWN_ROWS
    rows = [
        (session.name, *row) if batch else row
        for session in found.sessions
        for row in words.brief_rows(session.changed_views[:most])
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
