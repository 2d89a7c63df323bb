"""The command `classify`: what a cloud or a recording shows."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbitscan.processing.classification import PACKAGED
from orbitscan.recorder.cli.convert import Unit, parse_columns
from orbitscan.recorder.exceptions import InvalidOption, UnreadableCloud, setting

if TYPE_CHECKING:
    from orbitscan.processing.results.classification import SessionClassification, ViewClassification
    from orbitscan.recorder.session import Session


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
    from orbitscan.processing.results.folder import describe_damage

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
            print(f"A radius of {radius:.3g} m is not the size of any category: are --units and --scale right?")
    damage = describe_damage(session.damage, {view.index: view.damage for view in chosen if view.damage})
    if damage:
        typer.echo(f"{what}: {damage}", err=True)
        raise typer.Exit(1)


def _open(what: Path, axes: str | None, units: str | None, scale: float | None, columns: str | None) -> Session:
    """A recording, or a cloud as a session of one view."""
    if what.suffix.lower() == ".mcap":
        from orbitscan.recorder import mcap_file

        for name, said in (("axes", axes), ("units", units), ("scale", scale), ("columns", columns)):
            if said is not None:
                raise InvalidOption(setting(name, said), "a recording says it itself", "leave it out")
        return mcap_file.read(what)
    from orbitscan.recorder.conversion import CaptureOptions
    from orbitscan.recorder.sources import open_capture

    if what.is_dir():
        raise InvalidOption(what, "is a folder", "name one cloud, or make a recording of it with 'orbitscan convert'")
    names = parse_columns(columns)
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
