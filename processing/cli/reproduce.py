"""The command `reproduce`."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitscan.processing.cli.train import choose_device
from orbitscan.processing.reproduction import STUDIES, find
from orbitscan.recorder.cli.output import as_flags
from orbitscan.recorder.console import progress
from orbitscan.recorder.exceptions import InvalidOption, ScanError

if TYPE_CHECKING:
    from orbitscan.processing.reproduction.report import Report

_SHOWN_ROWS = 40
_LOG_WIDTH = 140


def reproduce(
    what: Annotated[str, typer.Argument(help=f"all, or one of {', '.join(STUDIES)}.", show_default=False)],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for numbers, figures and all runs.")
    ],
    runs: Annotated[
        int, typer.Option(help="Runs of every training, each from another seed. The thesis has 10 and 20.")
    ] = 10,
    fraction: Annotated[float, typer.Option(help="Share of the thesis's views to use, 0.005 to 1.")] = 1.0,
    dataset: Annotated[
        Path | None, typer.Option(help="The Washington RGB-D Object dataset. Default: the virtual corpus.")
    ] = None,
    device: Annotated[str, typer.Option(help="Where networks are trained: auto, cpu or cuda.")] = "auto",
    precision: Annotated[
        Literal["float32", "bfloat16"],
        typer.Option(help="Precision of the networks; bfloat16 is fast on some processors."),
    ] = "float32",
    workers: Annotated[
        int | None, typer.Option(min=1, help="Runs at the same time. Default: one for each core.")
    ] = None,
) -> None:
    """Make the thesis's tables and figures again, its numbers beside ours, and say which of its claims hold.

    Stopped and started again, it goes on with the runs that are missing.

    \b
    Examples:
      orbitscan reproduce table-5.2 -o reproduction
      orbitscan reproduce figure-5.8 -o reproduction
      orbitscan reproduce all --fraction 0.02 --runs 1 -o reproduction
    """
    if what != "all" and what not in STUDIES:
        raise InvalidOption(what, "no table or figure of the thesis", f"choose all, or one of {', '.join(STUDIES)}")
    from os import cpu_count

    from orbitscan.processing.batch.compilation import ensure_compiled
    from orbitscan.processing.reproduction.plan import Plan
    from orbitscan.processing.reproduction.report import write

    plan = Plan(
        folder=output,
        runs=runs,
        fraction=fraction,
        dataset=dataset,
        device=choose_device(device),
        precision=precision,
        workers=workers or cpu_count() or 1,
        progress=progress,
    )
    command = shlex.join(["orbitscan", *sys.argv[1:]])
    ensure_compiled()
    failed = False
    for name in STUDIES if what == "all" else [what]:
        try:
            report = find(name)(plan)
        except ScanError as error:
            if what != "all":
                raise
            typer.echo(f"{name}: {error.spelled(as_flags)}", err=True)
            failed = True
            continue
        paths = write(report, plan, command)
        _print_report(report)
        typer.echo(f"See {', '.join(map(str, paths))}\n")
    if what == "all":
        from orbitscan.processing.reproduction.index.writing import write_index

        page, recording = write_index(plan)
        typer.echo(f"Look at it all: {page}, and orbitscan view {recording}")
    raise typer.Exit(int(failed))


def _print_report(report: Report) -> None:
    """The numbers as a table, and what they say."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    columns = list(report.shown or report.rows[0])
    table = Table(title=f"{report.name}: {report.title}", title_justify="left", box=box.SIMPLE_HEAD, pad_edge=False)
    for name in columns:
        number = any(isinstance(row[name], int | float) for row in report.rows)
        table.add_column(Text(name.replace("_", " ")), justify="right" if number else "left", no_wrap=not number)
    for row in report.rows[:_SHOWN_ROWS]:
        table.add_row(*(Text(_cell(row[name])) for name in columns))
    console = Console()
    if not console.is_terminal:
        console.width = _LOG_WIDTH
    console.print(table)
    if len(report.rows) > _SHOWN_ROWS:
        typer.echo(f"... {len(report.rows) - _SHOWN_ROWS} more rows in {report.name}.csv")
    for sentence in (*report.said, *report.claims):
        typer.echo(sentence)


def _cell(value: str | int | float | None) -> str:
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
