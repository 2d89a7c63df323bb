"""The commands `info` and `check`: what a recording holds, and what would spoil its processing."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from orbitscan.recorder.exceptions import InvalidPose

INFO_VIEWS = "9"  # views that `info` measures
Recording = Annotated[Path, typer.Argument(help="A recording (.mcap).", metavar="SESSION.mcap", show_default=False)]


def info(recording: Recording) -> None:
    """Tell what a recording holds: views, poses, sizes, resolution, noise.

    \b
    Example:
      orbitscan info mug.mcap
    """
    import numpy as np

    from orbitscan.recorder import cloud, mcap_file
    from orbitscan.recorder.check import length, name_views
    from orbitscan.recorder.session import DEFAULT_VIEWS, select_views

    session = mcap_file.read(recording)
    facts = session.info
    measured = [cloud.measure(cloud.finite(view.points)[0]) for view in session.views(INFO_VIEWS)]
    measured = [fact for fact in measured if fact.points > 1]
    points, unreadable = [], []
    for view in session.views():
        points.append(len(cloud.finite(view.points)[0]))
        if view.damage:
            unreadable.append(view.index)
    damage = [session.damage] if session.damage else []
    damage += [f"{name_views(unreadable)} unreadable"] if unreadable else []
    used = select_views(str(DEFAULT_VIEWS), session.names)
    try:
        known = f"{len(session.truth())} of {facts.views}" + (f" ({facts.source_poses})" if facts.has_estimates else "")
    except InvalidPose as error:
        known = f"unreadable ({error.problem})"

    def median(of: Callable) -> float:
        return float(np.median([of(fact) for fact in measured])) if measured else float("nan")

    sides = " x ".join(f"{100 * median(lambda fact, i=i: fact.extent[i]):.1f}" for i in range(3))
    rows = {
        "name": facts.name,
        "category": " ".join(filter(None, (facts.category, facts.instance))) or "unknown",
        "source": ", ".join(filter(None, (facts.source, facts.sensor, f"capture {facts.capture}"))),
        "views": f"{facts.views} ({session.names[0]} ... {session.names[-1]})",
        "poses known": known,
        "extent": f"{sides} cm (width, height, depth of a view)",
        "distance": length(median(lambda fact: fact.distance)),
        "points": f"{min(points):,} / {int(np.median(points)):,} / {max(points):,} a view (least, median, most)",
        "resolution": f"{1000 * median(lambda fact: fact.resolution):.2f} mm",
        "noise": f"{1000 * median(lambda fact: fact.noise):.2f} mm",
        f"--views {DEFAULT_VIEWS}": "all" if len(used) == facts.views else " ".join(map(str, used)),
        "damage": "; ".join(damage) or "none",
    }
    for key, value in rows.items():
        print(f"{key:<12} {value}")


def check(recording: Recording) -> None:
    """Look for what would spoil the processing of a recording; exit status 1 where there is a problem.

    \b
    Example:
      orbitscan check mug.mcap
    """
    from orbitscan.recorder import mcap_file
    from orbitscan.recorder.check import check as find

    findings = find(mcap_file.read(recording))
    for finding in findings:
        print(finding)
    if any(finding.severity == "problem" for finding in findings):
        raise typer.Exit(1)
    print(f"next: orbitscan process {recording} -o results")
