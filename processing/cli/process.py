"""The command `process`: from recordings to results."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitscan.recorder.cli.output import as_flags
from orbitscan.recorder.console import progress
from orbitscan.recorder.exceptions import InvalidOption, setting

if TYPE_CHECKING:
    from orbitscan.processing.results.status import Method
    from orbitscan.processing.settings import Settings

VIEWER = "rerun+http://127.0.0.1:9876/proxy"  # where `rerun` listens


def process(
    recordings: Annotated[list[Path], typer.Argument(help="Recordings (.mcap), folders of them, or patterns.")],
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
    figures: Annotated[
        bool, typer.Option("--figures", help="Draw the error curves as PNG and SVG too, in the folder figures/.")
    ] = False,
    live: Annotated[bool, typer.Option("--live", help="Show the reviews in an open viewer as they grow.")] = False,
    viewer: Annotated[str, typer.Option(metavar="URL", help="Where that viewer listens.")] = VIEWER,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Recordings processed at the same time.")] = 1,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 where a view failed.")] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Do again what is done.")] = False,
) -> None:
    """Register the views of recordings, measure the errors, write results and a Rerun review.

    orbitscan process bunny.mcap -o results --views 0,1,2

    orbitscan process recordings/ -o results --workers 4 --methods icp,pairwise

    orbitscan process recordings/ -o results --live

    orbitscan process bottle.mcap -o results --step-deg 20 --mesh
    """
    from orbitscan.processing.batch.compilation import ensure_compiled
    from orbitscan.processing.batch.inputs import find_recordings, find_unfinished
    from orbitscan.processing.batch.recording import Job
    from orbitscan.processing.batch.workers import process_all, threads_per_worker
    from orbitscan.processing.cli.report import report_batch
    from orbitscan.processing.results.status import METHODS
    from orbitscan.processing.settings import THESIS_METHODS

    found = find_recordings(recordings)
    steps = _choose_settings(settings, step_deg, mesh)
    job = Job(
        results,
        views,
        _choose_methods(methods, THESIS_METHODS if settings == "thesis" else METHODS),
        steps,
        seed,
        overwrite,
        threads_per_worker(min(workers, len(found))),
        model=_choose_model(model),
        skip_unfinished=len(found) > 1,
        figures=figures,
        viewer=_choose_viewer(viewer) if live else None,
    )
    for path in find_unfinished(recordings):
        typer.echo(f"{path}: skipped: it is still being written, or its writer was stopped", err=True)
    ensure_compiled()
    outcomes = []
    for outcome in progress(process_all(found, job, workers), len(found), "Processing"):
        if outcome.error is not None and len(found) == 1:
            raise outcome.error
        said = outcome.error.spelled(as_flags) if outcome.error else f"{outcome.recording}: {outcome.message}"
        typer.echo(said, err=outcome.status != "done")
        if outcome.damage:
            typer.echo(f"{outcome.recording}: {outcome.damage}", err=True)
        outcomes.append(outcome)
    report_batch(outcomes, results, figures)
    done = [outcome for outcome in outcomes if outcome.status == "done"]
    if done:
        typer.echo(f"Look at it: orbitscan view {done[0].folder if len(outcomes) == 1 else results}")
    spoiled = any(outcome.error or outcome.damage or (strict and outcome.failed_views) for outcome in outcomes)
    raise typer.Exit(int(spoiled))


def _choose_settings(name: str, step_deg: float | None, mesh: bool) -> "Settings":
    """The settings of a file, or the default ones, with what the command line says besides."""
    from orbitscan.processing.settings import Settings, read_settings
    from orbitscan.recorder.libraries import load_open3d

    if step_deg is not None and not 0 < abs(step_deg) < 180:
        raise InvalidOption(setting("step_deg", step_deg), "not a turntable's step", "give degrees, such as 20 or -20")
    chosen = read_settings(Path(name), Settings) if name not in ("", "thesis") else Settings()
    if mesh or chosen.model.mesh.wanted:
        load_open3d("leave out --mesh")
    if step_deg is not None:
        chosen = replace(chosen, pair=replace(chosen.pair, step_deg=step_deg))
    if mesh:
        chosen = replace(chosen, model=replace(chosen.model, mesh=replace(chosen.model.mesh, wanted=True)))
    return chosen


def _choose_viewer(address: str) -> str:
    """The address of a viewer, of which one may be opened later; says so where nobody listens."""
    from orbitscan.processing.review.stream import is_address, is_open

    if not is_address(address):
        raise InvalidOption(setting("viewer", address), "not the address of a viewer", f"write it like {VIEWER}")
    if not is_open(address):
        remedy = "open one with 'rerun', and the next recordings show there"
        typer.echo(f"--live: no viewer is open at {address}; {remedy}", err=True)
    return address


def _choose_model(name: str) -> Path | None:
    """The file of the model that classifies; None for none. Raises InvalidOption where there is no such file."""
    from orbitscan.processing.classification import PACKAGED

    if name == "none":
        return None
    path = Path(name) if name else PACKAGED
    if not path.is_file():
        raise InvalidOption(setting("model", name), "no such file", "name a model of 'orbitscan train', or 'none'")
    return path


def _choose_methods(names: str, default: tuple[str, ...]) -> "tuple[Method, ...]":
    """The methods of a list with commas, worst to best; the default ones where it names none."""
    from orbitscan.processing.results.status import METHODS

    asked = [method.strip().replace("-", "_") for method in names.split(",") if method.strip()]
    if unknown := [method for method in asked if method not in METHODS]:
        raise InvalidOption(setting("methods", unknown[0]), "no such method", f"choose of {', '.join(METHODS)}")
    return tuple(method for method in METHODS if method in (asked or default))
