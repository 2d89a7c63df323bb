"""The command `simulate`: recordings of virtual objects."""

from typing import Annotated, Any, Literal

import typer

from orbitscan.recorder.cli.output import Output, place, tell_next, write
from orbitscan.recorder.console import progress
from orbitscan.recorder.exceptions import InvalidOption, Wording, setting


def simulate(
    what: Annotated[
        str,
        typer.Argument(
            metavar="OBJECT|MESH|corpus|others",
            help="robot, bin, statue, helicopter, vacuum_cleaner, apple, bell_pepper, bowl, cap, cell_phone, "
            "coffee_mug, dry_battery, notebook, pliers, water_bottle, other things such as banana or keyboard, "
            "or a mesh file; corpus: all instances of the thesis's ten categories; others: other things.",
        ),
    ],
    output: Output,
    instance: Annotated[int | None, typer.Option(help="Which instance of the object. Default: 1.")] = None,
    instances: Annotated[
        int | None, typer.Option(help="Instances of each category of a corpus. Default: the thesis's.")
    ] = None,
    views: Annotated[int | None, typer.Option(help="Views in one turn. Default: 18; of a corpus 200.")] = None,
    every: Annotated[int, typer.Option(help="Record only each so many-th of these views.")] = 1,
    elevation: Annotated[
        float | None,
        typer.Option(help="The camera's angle above the object, in degrees. Default: 30; of a corpus 30, 45 and 60."),
    ] = None,
    sensor: Annotated[
        Literal["gaussian", "kinect"] | None, typer.Option(help="The sensor. Default: gaussian; of a corpus kinect.")
    ] = None,
    distance: Annotated[
        float | None,
        typer.Option(help="The camera's distance, in metres. Default: 1 (kinect 0.72) or 2.5 radii of a large object."),
    ] = None,
    focal: Annotated[float | None, typer.Option(help="The focal length, in pixels. Default: 525 (kinect 570).")] = None,
    noise_mm: Annotated[
        float, typer.Option(help="Standard deviation of the depth at 1 m; grows with its square.")
    ] = 1.0,
    paint: Annotated[
        Literal["own", "plain", "label", "stripe", "print"],
        typer.Option(help="The object's own colours; one colour; with a label, a stripe, or a print all round."),
    ] = "own",
    lamp: Annotated[
        Literal["object", "camera", "room"],
        typer.Option(help="What lights it stands still beside the object, moves with the camera, or the object turns."),
    ] = "object",
    gloss: Annotated[float, typer.Option(help="Brightness of its highlights, 0 to 1.")] = 0.0,
    color_noise: Annotated[float, typer.Option(help="Standard deviation of a colour channel, of 255.")] = 0.0,
    color_shift: Annotated[float, typer.Option(help="Pixels by which colours lie beside their depths.")] = 0.0,
    seed: Annotated[int, typer.Option(help="The seed of the noise.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Circles of a corpus recorded at the same time.")] = 1,
) -> None:
    """Scan an object or a mesh (metres) with a virtual depth camera; the poses are exact.

    A corpus is a folder of such circles, of many objects from three heights; finished ones are kept when it is started
    again.

    \b
    Examples:
      orbitscan simulate robot -o robot.mcap
      orbitscan simulate cup.stl -o cup.mcap --views 36 --noise-mm 2
      orbitscan simulate coffee_mug -o mug.mcap --sensor kinect
      orbitscan simulate corpus -o corpus/ --every 10 --workers 4
    """
    from dataclasses import replace

    from orbitscan.recorder.simulation import camera, corpus, objects

    of_many = what in ("corpus", "others")
    said = {"views": views, "elevation_deg": elevation, "sensor": sensor, "distance": distance, "focal": focal}
    given: dict[str, Any] = {name: value for name, value in said.items() if value is not None}
    eye = corpus.CAMERA if of_many else camera.Camera()
    given |= {"paint": paint, "lamp": lamp, "gloss": gloss, "color_noise": color_noise, "color_shift": color_shift}
    eye = replace(eye, every=every, noise_mm=noise_mm, seed=seed, **given)
    if not of_many:
        if instances is not None:
            remedy = Wording("name 'corpus', or use {instance}")
            raise InvalidOption(setting("instances", instances), f"is not for {what}", remedy)
        path, session = place(camera.simulate(what, 1 if instance is None else instance, eye), output, None)
        write(session, path)
        tell_next(output)
        return
    for option, value in (("instance", instance), ("elevation", elevation)):
        if value is not None:
            raise InvalidOption(setting(option, value), f"is not for {what}", "leave it out, or name one object")
    if instances is not None and instances < 1:
        raise InvalidOption(setting("instances", instances), "a category has at least one", "give 1 or more")
    table = corpus.INSTANCES if what == "corpus" else dict.fromkeys(objects.OTHERS, corpus.OTHER_INSTANCES)
    circles = corpus.plan({name: instances or count for name, count in table.items()})
    recorded = list(progress(corpus.record_all(circles, output, eye, workers), len(circles), "Recording"))
    kept = sum(circle.kept for circle in recorded)
    total = sum(circle.views for circle in recorded)
    print(f"{output}: {len(recorded)} recordings, {total:,} views" + (f"; {kept} were there already" if kept else ""))
    print(f"next: orbitscan train {output} -o model.pt")
