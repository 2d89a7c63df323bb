"""The command `orbitscan`: the recorder's commands, and from recordings to results."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from processing import model_cli, reproduce_cli, review_cli
from recorder import cli as recorder_cli
from recorder.exceptions import InvalidOption
from recorder.progress import progress

if TYPE_CHECKING:
    from processing.batch import Job, Outcome
    from processing.settings import Settings

app = typer.Typer(
    name="orbitscan",
    help="Scans of objects: recorded as MCAP, registered into the whole object, reviewed in Rerun.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
recorder_cli.mount(app)
model_cli.mount(app)
reproduce_cli.mount(app)
review_cli.mount(app)

_AMBIGUOUS = "the object looks the same from several sides; if you know the turntable's step, --step-deg settles it"
_COLUMNS = {  # of the printed table -> key of the summary, factor to the unit shown
    "failed\nviews": ("failed_views", 1),
    "transl.\nmax [mm]": ("max_translation_error_m", 1e3),
    "chordal\nmedian": ("median_rotation_error_chordal", 1),
    "chordal\nmax": ("max_rotation_error_chordal", 1),
    "angle\nmax [deg]": ("max_rotation_error_deg", 1),
    "centre\nmax [mm]": ("max_center_error_m", 1e3),
}


@app.command()
def process(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings (.mcap), or folders of them.")],
    results: Annotated[Path, typer.Option("-o", "--output", help="Gets a folder for each recording.")],
    views: Annotated[str, typer.Option(help="A count, 'all', a list 0,1,5, a range 0:12, or names 'bun*'.")] = "18",
    methods: Annotated[
        str, typer.Option(help="Of icp, ransac_icp, pairwise, refined; with commas. Default: all.")
    ] = "",
    settings: Annotated[str, typer.Option(help="A TOML file, or 'thesis': its methods alone.")] = "",
    model: Annotated[
        str, typer.Option(metavar="MODEL.pt|none", help="What classifies the views. Default: the packaged one.")
    ] = "",
    step_deg: Annotated[
        float | None,
        typer.Option(
            help="The turntable's step, believed where the views cannot tell; positive: camera counterclockwise."
        ),
    ] = None,
    mesh: Annotated[bool, typer.Option("--mesh", help="Write model_mesh.ply too, by Poisson reconstruction.")] = False,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Recordings processed at the same time.")] = 1,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 where a view failed.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Do again what is done.")] = False,
) -> None:
    """Register the views of recordings, measure the errors, write results and a Rerun review.

    orbitscan process bunny.mcap -o results --views 0,1,2

    orbitscan process recordings/ -o results --workers 4 --methods icp,pairwise

    orbitscan process bottle.mcap -o results --step-deg 20 --mesh
    """
    from processing.batch import find_recordings, process_all
    from processing.compilation import ensure_compiled

    found = find_recordings(recordings)
    steps = _choose_settings(settings, step_deg, mesh)
    job = replace(
        _make_job(results, views, methods, settings == "thesis", steps, seed, overwrite, min(workers, len(found))),
        model=_choose_model(model),
    )
    ensure_compiled(partial(typer.echo, err=True))
    outcomes = []
    for outcome in progress(process_all(found, job, workers), len(found), "Processing"):
        if outcome.error is not None and len(found) == 1:
            raise outcome.error
        typer.echo(f"{outcome.recording}: {outcome.message}", err=outcome.error is not None)
        if outcome.damage:
            typer.echo(f"{outcome.recording}: {outcome.damage}", err=True)
        outcomes.append(outcome)
    done = [outcome for outcome in outcomes if outcome.summaries]
    _print_errors(done)
    _report_confusion(done, results)
    for outcome in done:
        if outcome.ambiguous_views:
            typer.echo(f"{outcome.folder.name}: {outcome.ambiguous_views} views are ambiguous: {_AMBIGUOUS}")
    if done:
        typer.echo(f"Look at it: orbitscan view {done[0].folder if len(done) == 1 else results}")
    raise typer.Exit(_exit_status(outcomes, strict))


def _choose_settings(name: str, step_deg: float | None, mesh: bool) -> "Settings":
    """The settings of a file, or the default ones, with what the command line says besides."""
    from processing.settings import Settings, read_settings

    if step_deg is not None and not 0 < abs(step_deg) < 180:
        raise InvalidOption(f"--step-deg {step_deg:g}", "no step of a turntable", "give degrees, such as 20 or -20")
    chosen = read_settings(Path(name)) if name not in ("", "thesis") else Settings()
    if step_deg is not None:
        chosen = replace(chosen, pair=replace(chosen.pair, step_deg=step_deg))
    return (
        replace(chosen, model=replace(chosen.model, mesh=replace(chosen.model.mesh, wanted=True))) if mesh else chosen
    )


def _choose_model(name: str) -> Path | None:
    """The file of the model that classifies; None for none. Raises InvalidOption where there is no such file."""
    from processing.classification import PACKAGED

    if name == "none":
        return None
    path = Path(name) if name else PACKAGED
    if not path.is_file():
        raise InvalidOption(f"--model {name}", "no such file", "name a model of 'orbitscan train', or 'none'")
    return path


def _make_job(
    results: Path,
    views: str,
    methods: str,
    thesis: bool,
    settings: "Settings",
    seed: int,
    overwrite: bool,
    workers: int,
) -> "Job":
    from processing.batch import Job, threads_per_worker
    from processing.results.records import METHODS
    from processing.settings import THESIS_METHODS

    asked = [method.strip().replace("-", "_") for method in methods.split(",") if method.strip()]
    if unknown := [method for method in asked if method not in METHODS]:
        raise InvalidOption(f"--methods {unknown[0]}", "no such method", f"choose of {', '.join(METHODS)}")
    default = THESIS_METHODS if thesis else METHODS
    return Job(
        results,
        views,
        tuple(method for method in METHODS if method in (asked or default)),
        settings,
        seed,
        overwrite,
        threads_per_worker(workers),
    )


def _print_errors(outcomes: list["Outcome"]) -> None:
    """A row per session and method: views not placed with confidence, and errors where the truth is known."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(
        title="Errors against the ground truth",
        title_justify="left",
        box=box.SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
        pad_edge=False,
    )
    table.add_column("session", overflow="fold", min_width=7)
    table.add_column("method", no_wrap=True)
    for column in _COLUMNS:
        table.add_column(Text(column), justify="right", no_wrap=True)  # Text: [mm] is no markup
    for outcome in outcomes:
        names = [outcome.folder.name] + [""] * len(outcome.summaries)
        for name, (method, summary) in zip(names, outcome.summaries.items(), strict=False):
            table.add_row(name, method, *(_cell(summary[key], factor) for key, factor in _COLUMNS.values()))
    if outcomes:
        Console().print(table)


def _report_confusion(outcomes: list["Outcome"], results: Path) -> None:
    """Write and print what recordings whose category is known are taken for, where there are several."""
    from processing.results.confusion import count_confusion, tabulate, write_csv

    found = count_confusion([outcome.folder for outcome in outcomes])
    if found is None:
        return
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from processing.review.confusion import count_right, write_confusion

    write_csv(results / "confusion.csv", found)
    write_confusion(results / "confusion.rrd", found)
    table = Table(title="Categories", title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for column in ("category", "recordings right", "views right", "taken for"):
        table.add_column(column, overflow="fold")
    for row in tabulate(found):
        table.add_row(*row)
    Console().print(table)
    typer.echo(f"{count_right(found)} See {results / 'confusion.rrd'}")


def _cell(value: Any, factor: float) -> str:
    return "-" if value is None else f"{value * factor:.3g}"


def _exit_status(outcomes: list["Outcome"], strict: bool) -> int:
    spoiled = any(outcome.error or outcome.damage or (strict and outcome.failed_views) for outcome in outcomes)
    return 1 if spoiled else 0


def main() -> None:
    """Run the command."""
    recorder_cli.run(app)
