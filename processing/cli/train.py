"""The command `train`: a classifier from labelled recordings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from orbitscan.recorder.console import progress
from orbitscan.recorder.exceptions import InvalidOption, UnwritableOutput, setting

if TYPE_CHECKING:
    from orbitscan.processing.classification.labelled_views import LabelledViews, Split
    from orbitscan.processing.classification.training import TrainingSettings
    from orbitscan.recorder.session import Session


def train(
    recordings: Annotated[list[Path], typer.Argument(help="Labelled recordings (.mcap), or folders of them.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="MODEL.pt", help="The trained model.")],
    unknown: Annotated[
        list[Path] | None, typer.Option(help="Recordings of other things, to learn what is none of the categories.")
    ] = None,
    settings: Annotated[str, typer.Option(help="A TOML file, or 'thesis': counts, two epochs, no augmentation.")] = "",
    structure: Annotated[
        str, typer.Option(help="The network's layers, such as C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10).")
    ] = "",
    init: Annotated[
        Literal["glorot", "dcae", "kmeans-pca", "kmeans-zca"] | None,
        typer.Option(help="How the first weights are found."),
    ] = None,
    orientation: Annotated[bool, typer.Option("--orientation", help="Learn the side that is seen, too.")] = False,
    epochs: Annotated[int | None, typer.Option(min=1, help="How often every view is trained on.")] = None,
    validate: Annotated[
        str, typer.Option(help="Instances of each category to validate on: 'last', a number, or a share such as '20%'.")
    ] = "",
    test: Annotated[
        str,
        typer.Option(help="Instances to test on, said likewise, or names or patterns of recordings. Default: none."),
    ] = "",
    split: Annotated[
        Literal["instances", "views"],
        typer.Option(help="What is kept apart: 'views' is for data of a single instance."),
    ] = "instances",
    every: Annotated[int, typer.Option(min=1, help="Use every n-th view.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all random numbers.")] = 0,
    device: Annotated[str, typer.Option(help="Where to train: auto, cpu or cuda.")] = "auto",
) -> None:
    """Train a classifier on labelled recordings, with a review of the training beside the model.

    Split by instance, never by view: one instance of each category is kept to validate. Stopped and started again, it
    goes on after the last whole epoch.

    \b
    Examples:
      orbitscan train corpus/ -o model.pt --test last
      orbitscan train corpus/ -o model.pt --unknown others/
      orbitscan train lidar/ -o lidar.pt --validate 20% --test 20%
    """
    from orbitscan.processing.batch.inputs import find_recordings
    from orbitscan.processing.classification import checkpoint
    from orbitscan.processing.classification.checkpoint import Checkpoint
    from orbitscan.processing.classification.evaluation import EpochRecord
    from orbitscan.processing.classification.labelled_views import gather, join, split_views
    from orbitscan.processing.classification.training import train as run
    from orbitscan.processing.review.training.recording import TrainingReview

    _check_output(output)
    chosen = _choose_settings(settings, structure, init, orientation, epochs)
    place = choose_device(device)
    paths = find_recordings(recordings)
    views = gather(_read(paths, "Reading"), None, split, every, chosen.voxels.trim)
    if unknown:
        others = find_recordings(unknown)
        views = join(views, gather(_read(others, "Reading others"), views.names, split, every, chosen.voxels.trim))
    rows = split_views(views, validate or ("20%" if split == "views" else "last"), test, seed)
    if split == "views":
        print("split by views: training and test show the same things; the figures below do not hold for others")
    print(_describe(views, rows))
    state, metrics = output.with_name(output.name + ".state"), {}
    review = output.with_suffix(".rrd")
    with TrainingReview(review, views.names, chosen) as stream:
        for result in run(views, rows, chosen, seed=seed, device=place, state=state):
            if isinstance(result, EpochRecord):
                stream.add(result)
                print(
                    f"epoch {result.epoch:3d}  loss {result.train_loss:.4f} / {result.validation_loss:.4f}  "
                    f"accuracy {100 * result.train_accuracy:.2f} / {100 * result.validation_accuracy:.2f} %  "
                    f"(training / validation), {result.views_per_second:.0f} views/s",
                    flush=True,
                )
            elif isinstance(result, Checkpoint):
                checkpoint.save(result, output)
                metrics = result.metrics
    state.unlink(missing_ok=True)
    for name, values in metrics.items():
        print(f"{name}: " + ", ".join(f"{key.replace('_', ' ')} {value:.4g}" for key, value in values.items()))
    print(f"next: orbitscan classify SESSION.mcap --model {output}, or: orbitscan view {review}")


def choose_device(name: str) -> str:
    """The torch device that `--device` names. Raises InvalidOption."""
    import torch

    count = torch.cuda.device_count()
    if name == "auto":
        return "cuda" if count else "cpu"
    if name.startswith("cuda") and not count:
        raise InvalidOption(setting("device", name), "there is no CUDA device here", "give cpu, or leave it out")
    if name not in ("cpu", "cuda", *(f"cuda:{i}" for i in range(count))):
        raise InvalidOption(setting("device", name), "not a device", "give auto, cpu or cuda")
    return name


def _read(paths: list[Path], what: str) -> Iterator[Session]:
    from orbitscan.recorder import mcap_file

    for session in progress(map(mcap_file.read, paths), len(paths), what):
        if session.damage:
            typer.echo(f"{session.info.name}: {session.damage}", err=True)
        yield session


def _choose_settings(
    name: str, structure: str, init: str | None, orientation: bool, epochs: int | None
) -> TrainingSettings:
    """The settings of a preset or a file, with what the command line says besides."""
    from orbitscan.processing.classification.training import THESIS, TrainingSettings
    from orbitscan.processing.settings import read_settings

    presets = {"": TrainingSettings(), "thesis": THESIS}
    chosen = presets.get(name) or read_settings(Path(name), TrainingSettings)
    said: dict[str, Any] = {"structure": structure, "init": init, "orientation": orientation, "epochs": epochs}
    chosen = replace(chosen, **{key: value for key, value in said.items() if value})
    if chosen.orientation:  # a turned view shows another side
        chosen = replace(chosen, augmentation=replace(chosen.augmentation, turn_deg=0.0))
    return chosen


def _check_output(output: Path) -> None:
    """Raises where a trained model could not be kept, before it is trained."""
    if output.is_dir():
        raise UnwritableOutput(output, "is a folder", "name a file, such as model.pt")
    if output.suffix.lower() in (".mcap", ".rrd"):
        raise InvalidOption(output, "is the name of a recording or a review", "let the model's end with .pt")


def _describe(views: LabelledViews, rows: Split) -> str:
    """How many instances and views train, validate and test."""
    parts = {"train": rows.train, "validate": rows.validation, "test": rows.test}
    counts = [f"{len(set(views.units[part]))} instances ({len(part):,} views) {name}" for name, part in parts.items()]
    return f"{len(views.names)} categories: " + ", ".join(counts)
