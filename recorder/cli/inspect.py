"""The commands `info` and `check`: what a recording holds, and what would spoil its processing."""

from pathlib import Path
from typing import Annotated

import typer

from orbitscan.recorder.cli.output import as_flags

Recording = Annotated[Path, typer.Argument(help="A recording (.mcap).", metavar="SESSION.mcap", show_default=False)]


def info(recording: Recording) -> None:
    """Tell what a recording holds: views, poses, sizes, resolution, noise.

    \b
    Example:
      orbitscan info mug.mcap
    """
    from orbitscan.recorder import mcap_file
    from orbitscan.recorder.check import length
    from orbitscan.recorder.facts import gather_facts
    from orbitscan.recorder.session import DEFAULT_VIEWS

    facts = gather_facts(mcap_file.read(recording))
    info = facts.info
    known = f"{facts.poses} of {info.views}" + (f" ({info.source_poses})" if info.has_estimates else "")
    least, median, most = facts.points
    rows = {
        "name": info.name,
        "category": " ".join(filter(None, (info.category, info.instance))) or "unknown",
        "source": ", ".join(filter(None, (info.source, info.sensor, f"capture {info.capture}"))),
        "views": f"{info.views} ({facts.names[0]} ... {facts.names[-1]})",
        "poses known": known if facts.poses is not None else f"unreadable ({facts.unreadable_poses})",
        "extent": f"{' x '.join(f'{100 * side:.1f}' for side in facts.extent)} cm (width, height, depth of a view)",
        "distance": length(facts.distance),
        "points": f"{least:,} / {median:,} / {most:,} a view (least, median, most)",
        "resolution": f"{1000 * facts.resolution:.2f} mm",
        "noise": f"{1000 * facts.noise:.2f} mm",
        f"--views {DEFAULT_VIEWS}": "all" if len(facts.used) == info.views else " ".join(map(str, facts.used)),
        "damage": facts.damage or "none",
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
        print(finding.spelled(as_flags))
    if any(finding.severity == "problem" for finding in findings):
        raise typer.Exit(1)
    print(f"next: orbitscan process {recording} -o results")
