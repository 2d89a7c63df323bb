"""What a batch prints and leaves beside its results: tables of errors and categories, and the summary files."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import typer

from orbitscan.processing.batch.recording import Outcome
from orbitscan.processing.results.batch_table import Row, read_row, worst_first, write_table
from orbitscan.processing.results.confusion import count_confusion, write_csv
from orbitscan.processing.results.confusion import tabulate as tabulate_confusion
from orbitscan.processing.results.estimates import MethodResult
from orbitscan.processing.review.ambiguity import (
    find_freedoms,
    find_symmetries,
    is_open,
    list_ambiguous,
    list_settled,
    tell_apart,
)
from orbitscan.processing.review.markdown import (
    UNCHALLENGED,
    UNCHALLENGED_WORDS,
    count_not_ok,
    describe_freedom,
    describe_symmetry,
    enumerate_some,
    enumerate_views,
    plural,
)
from orbitscan.recorder.cli.output import as_flags
from orbitscan.recorder.console import print_table

SHOWN_RECORDINGS = 12  # of a batch; the rest is in summary.csv
SHOWN_MOTIONS = 3  # free motions, and symmetries, of a recording
_NOT_OK = "views\nnot ok"
_COLUMNS = {  # of the printed table -> key of the summary, factor to the unit shown
    "transl.\nmax [mm]": ("max_translation_error_m", 1e3),
    "chordal\nmedian": ("median_rotation_error_chordal", 1),
    "chordal\nmax": ("max_rotation_error_chordal", 1),
    "angle\nmax [deg]": ("max_rotation_error_deg", 1),
    "centre\nmax [mm]": ("max_center_error_m", 1e3),
}
_KNOWN_TOO_BADLY = "nothing competes with their poses, but the views hold them too loosely; the review tells how well"
_AMBIGUOUS = "the object looks the same from several sides; if you know the turntable's step, --step-deg settles it"


def report_batch(outcomes: Sequence[Outcome], results: Path, figures: bool = False) -> None:
    """Print the errors; of several recordings write and print the summary and what their categories are taken for.

    Raises UnwritableOutput.
    """
    rows = worst_first([_row(outcome) for outcome in outcomes])
    _print_errors([row for row in rows if row.results])
    for row in rows[:SHOWN_RECORDINGS]:
        if row.results and row.results.best:
            for line in _tell_what_is_open(row.results.best):
                typer.echo(f"{row.session}: {line}")
    for row in rows:
        if row.results and (best := row.results.best) and (views := list_ambiguous(best)):
            why = _AMBIGUOUS if is_open(best) else _KNOWN_TOO_BADLY
            typer.echo(f"{row.session}: {len(views)} views are ambiguous: {why}")
    if len(outcomes) > 1:
        _write_summary(rows, results)
    if len(outcomes) > 1 and figures:
        from orbitscan.processing.review.figures.batch import write_batch_figure

        write_batch_figure(results, rows)


def _row(outcome: Outcome) -> Row:
    if outcome.status == "done":
        return read_row(outcome.folder)
    said = outcome.error.spelled(as_flags) if outcome.error else outcome.message
    return Row(outcome.folder.name, outcome.status, said)


def _write_summary(rows: Sequence[Row], results: Path) -> None:
    from orbitscan.processing.review.batch.confusion import count_right
    from orbitscan.processing.review.batch.recording import conclude, write_batch

    confusion = count_confusion([row.results for row in rows if row.results])
    write_table(results, rows)
    write_batch(results / "summary.rrd", results.resolve().name, rows, confusion)
    if confusion is None:
        (results / "confusion.csv").unlink(missing_ok=True)  # of an earlier batch
    else:
        write_csv(results / "confusion.csv", confusion)
        columns = ("category", "recordings right", "views right", "taken for")
        print_table("Categories", {name: {"overflow": "fold"} for name in columns}, tabulate_confusion(confusion))
        typer.echo(count_right(confusion))
    typer.echo(f"{conclude(rows)} See {results / 'summary.rrd'}, summary.csv, summary.parquet")


def _print_errors(rows: Sequence[Row]) -> None:
    """A row per recording and method, worst first: views that are not ok, and errors where the truth is known."""
    columns: dict[str, dict[str, Any]] = {"session": {"overflow": "fold", "min_width": 7}, "method": {"no_wrap": True}}
    columns |= {name: {"justify": "right", "no_wrap": True} for name in (_NOT_OK, *_COLUMNS)}
    lines = []
    for row in rows[:SHOWN_RECORDINGS]:
        for number, method in enumerate(row.results.reconstruction if row.results else ()):
            cells = (_cell(row.of(method, key), factor) for key, factor in _COLUMNS.values())
            not_ok = count_not_ok(row.of(method, "failed_views"), method)
            lines.append([row.session if number == 0 else "", method, not_ok, *cells])
    print_table("Errors against the ground truth", columns, lines)
    if any(method in UNCHALLENGED for row in rows for method in (row.results.reconstruction if row.results else ())):
        typer.echo(UNCHALLENGED_WORDS)
    if len(rows) > SHOWN_RECORDINGS:
        typer.echo(f"and {len(rows) - SHOWN_RECORDINGS} with smaller errors: summary.csv has them all")


def _tell_what_is_open(found: MethodResult) -> Iterator[str]:
    """Free motions and symmetries that a method finds, and which views something else settled, a line each."""
    (freedoms, _), (symmetries, _) = find_freedoms(found), find_symmetries(found)
    if freedoms:
        yield f"cannot be told: {enumerate_some([*map(describe_freedom, freedoms)], SHOWN_MOTIONS)}"
    for symmetry in symmetries[:SHOWN_MOTIONS]:
        yield describe_symmetry(symmetry)
    if more := len(symmetries[SHOWN_MOTIONS:]):
        yield f"and {more} more such symmetries"
    yield from tell_apart(found)
    for words, settled in list_settled(found).items():
        yield f"{plural(len(settled), 'view')} {enumerate_views(settled)} by {words}"


def _cell(value: float | None, factor: float) -> str:
    return "-" if value is None else f"{value * factor:.3g}"
