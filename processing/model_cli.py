"""The commands `classify` and `train`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from orbitscan.processing.classification import PACKAGED
from orbitscan.recorder import cli as recorder_cli
from orbitscan.recorder.console import progress
from orbitscan.recorder.exceptions import InvalidOption, UnreadableCloud, UnwritableOutput

if TYPE_CHECKING:
    from orbitscan.processing.classification.labelled_views import LabelledViews, Split
    from orbitscan.processing.classification.training import TrainingSettings
    from orbitscan.processing.results.records import SessionClassification, ViewClassification
    from orbitscan.recorder.session import Session

Unit = Literal["m", "cm", "mm"]


def classify(
    what: Annotated[Path, typer.Argument(metavar="CLOUD|SESSION.mcap", help="A cloud, or a recording.")],
    model: Annotated[
        Path, typer.Option(help="Made by 'orbitscan train'. Default: the ten household things.")
    ] = PACKAGED,
    axes: Annotated[
        str | None, typer.Option(help="Where x, y, z of a cloud point, as the camera sees it. Default: RDF.")
    ] = None,
    units: Annotated[Unit | None, typer.Option(help="Of a cloud's points. Default: m.")] = None,
    scale: Annotated[float | None, typer.Option(help="Times the units of a cloud. Default: 1.")] = None,
    columns: Annotated[
        str | None, typer.Option(metavar="X,Y,Z", help="Which named columns of a text file are x, y, z.")
    ] = None,
    views: Annotated[str, typer.Option(help="Of a recording: a count, 'all', a list, a range, names.")] = "all",
    json_: Annotated[bool, typer.Option("--json", help="Print the answer as JSON.")] = False,
) -> None:
    """Say what a view shows, or the views of a recording together, and whether the model knows it at all.

    \b
    Examples:
      orbitscan classify mug.pcd --axes RFU
      orbitscan classify mug.mcap --json
    """
    import json
    from dataclasses import asdict

    from orbitscan.processing.classification.classifier import Classifier
    from orbitscan.processing.results.files import describe_damage

    session = _open(what, axes, units, scale, columns)
    classifier = Classifier(model)
    chosen = list(session.views(views))
    if all(view.damage for view in chosen):
        raise UnreadableCloud(what, "no view can be read", "record it again")
    found = [v for v in classifier.classify_views([v.index for v in chosen], [v.points for v in chosen]) if v]
    fused = classifier.fuse(found)
    if fused is None:
        raise UnreadableCloud(what, "too few finite points to tell anything", "look at it with 'orbitscan view'")
    if json_:
        print(json.dumps(asdict(fused), indent=1))
    else:
        for view in found if len(found) > 1 else ():
            print(f"view {view.view:4d}  {_answer(view)}")
        print(f"{what}: {_sentence(fused)}")
        radius = classifier.odd_radius([view.points for view in chosen])
        if radius is not None:
            print(f"A radius of {radius:.3g} m is no size of any category: are --units and --scale right?")
    damage = describe_damage(session.damage, {view.index: view.damage for view in chosen if view.damage})
    if damage:
        typer.echo(f"{what}: {damage}", err=True)
        raise typer.Exit(1)


def train(
    recordings: Annotated[list[Path], typer.Argument(help="Labelled recordings (.mcap), or folders of them.")],
    output: Annotated[Path, typer.Option("-o", "--output", metavar="MODEL.pt", help="The trained model.")],
    unknown: Annotated[
        list[Path] | None, typer.Option(help="Recordings of other things, which teach what is none of them.")
    ] = None,
    settings: Annotated[str, typer.Option(help="A TOML file, or 'thesis': counts, two epochs, no augmentation.")] = "",
    structure: Annotated[str, typer.Option(help="As C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10).")] = "",
    init: Annotated[
        Literal["glorot", "dcae", "kmeans-pca", "kmeans-zca"] | None, typer.Option(help="The first weights.")
    ] = None,
    orientation: Annotated[bool, typer.Option("--orientation", help="Learn the side that is seen, too.")] = False,
    epochs: Annotated[int | None, typer.Option(min=1, help="Times that every view is trained on.")] = None,
    validate: Annotated[str, typer.Option(help="Instances of each category: 'last', a number, a share '20%'.")] = "",
    test: Annotated[str, typer.Option(help="The same, or names or patterns of recordings. Default: none.")] = "",
    split: Annotated[
        Literal["instances", "views"], typer.Option(help="Of a single instance, views may be split; say so.")
    ] = "instances",
    every: Annotated[int, typer.Option(min=1, help="Of the views: each so-many-th.")] = 1,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    device: Annotated[str, typer.Option(help="auto, cpu or cuda.")] = "auto",
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
    from orbitscan.processing.classification import checkpoint
    from orbitscan.processing.classification.evaluation import EpochRecord
    from orbitscan.processing.classification.labelled_views import gather, join, split_views
    from orbitscan.processing.classification.training import train as run
    from orbitscan.processing.inputs import find_recordings
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
    state = output.with_name(output.name + ".state")
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
            else:
                checkpoint.save(result, output)
    state.unlink(missing_ok=True)
    for name, values in result.metrics.items():
        print(f"{name}: " + ", ".join(f"{key.replace('_', ' ')} {value:.4g}" for key, value in values.items()))
    print(f"next: orbitscan classify SESSION.mcap --model {output}, or: orbitscan view {review}")


def choose_device(name: str) -> str:
    """The torch device that `--device` names. Raises InvalidOption."""
    import torch

    count = torch.cuda.device_count()
    if name == "auto":
        return "cuda" if count else "cpu"
    if name.startswith("cuda") and not count:
        raise InvalidOption(f"--device {name}", "there is no CUDA device here", "give cpu, or leave it out")
    if name not in ("cpu", "cuda", *(f"cuda:{i}" for i in range(count))):
        raise InvalidOption(f"--device {name}", "no device", "give auto, cpu or cuda")
    return name


def mount(app: typer.Typer) -> None:
    """Add the commands to an application."""
    for command in (classify, train):
        app.command()(command)


def _open(what: Path, axes: str | None, units: str | None, scale: float | None, columns: str | None) -> Session:
    """A recording, or a cloud as a session of one view."""
    if what.suffix.lower() == ".mcap":
        from orbitscan.recorder import mcap_file

        for name, said in (("axes", axes), ("units", units), ("scale", scale), ("columns", columns)):
            if said is not None:
                raise InvalidOption(f"--{name} {said}", "a recording says it itself", "leave it out")
        return mcap_file.read(what)
    from orbitscan.recorder.sources import open_capture
    from orbitscan.recorder.sources.options import CaptureOptions

    if what.is_dir():
        raise InvalidOption(what, "is a folder", "name one cloud, or make a recording of it with 'orbitscan convert'")
    names = recorder_cli.parse_columns(columns)
    options = CaptureOptions(format="clouds", axes=axes, units=units, scale=scale, columns=names)
    (session,) = open_capture(what, options)
    return session


def _answer(found: ViewClassification | SessionClassification) -> str:
    """The likeliest categories, or `unknown` first."""
    probabilities = found.probabilities if hasattr(found, "probabilities") else found.fused[-1]
    ranked = sorted(probabilities.items(), key=lambda item: -item[1])[:3]
    likeliest = ", ".join(f"{name} {100 * p:.1f} %" for name, p in ranked if p >= 0.005)
    return likeliest if found.known else f"unknown (if any of its categories: {likeliest})"


def _sentence(fused: SessionClassification) -> str:
    views = len(fused.views)
    unknown = sum(not view.known for view in fused.views)
    return _answer(fused) + (f", fused over {views} views, of which {unknown} alone unknown" if views > 1 else "")


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

    if name == "thesis":
        chosen = THESIS
    elif name:
        chosen = read_settings(Path(name), TrainingSettings)
    else:
        chosen = TrainingSettings()
    said = {"structure": structure, "init": init, "orientation": orientation, "epochs": epochs}
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
