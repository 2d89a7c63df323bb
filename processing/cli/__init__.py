"""The command `orbitscan`: a module for each command; the recorder's come first."""

from importlib.metadata import version
from typing import Annotated

import typer

from orbitscan.processing.cli import classify, compare, process, reproduce, train, view
from orbitscan.recorder import cli as recorder_cli
from orbitscan.recorder.caches import find_place_for_matplotlib

app = typer.Typer(name="orbitscan", no_args_is_help=True, pretty_exceptions_enable=False, add_completion=False)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"orbitscan {version('orbitscan')}")
        raise typer.Exit


@app.callback()
def orbitscan(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Scans of objects: recorded as MCAP, registered into the whole object, reviewed in Rerun."""


for command in (
    *recorder_cli.COMMANDS,
    process.process,
    view.view,
    compare.compare,
    classify.classify,
    train.train,
    reproduce.reproduce,
):
    app.command()(command)


def main() -> None:
    """Run the command."""
    find_place_for_matplotlib()
    recorder_cli.run(app)
