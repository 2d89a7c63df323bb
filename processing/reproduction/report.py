"""What a study found: numbers as CSV and JSON, figures as PNG and SVG, claims with their verdicts, and plain words."""

import csv
import io
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from os import cpu_count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter

from orbitscan.processing.reproduction.claims import Claim
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.recorder.atomic import write_whole
from orbitscan.recorder.exceptions import InvalidOption

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMAT_VERSION = 2
_LIBRARIES = ("numpy", "scipy", "numba", "torch", "scikit-learn", "open3d", "matplotlib")
Value = str | int | float | None  # None: not known
Row = Mapping[str, Value]


@dataclass(frozen=True, eq=False)
class Report:
    """A table or figure of the thesis, made again."""

    name: str  # as the command names it: table-5.1
    title: str
    rows: Sequence[Row]  # all of the same keys, units in their names
    said: Sequence[str] = ()  # sentences, computed from the numbers
    claims: Sequence[Claim] = ()
    figures: Mapping[str, "Figure"] = field(default_factory=dict)  # by file name, without the ending
    settings: Mapping[str, Any] = field(default_factory=dict)  # besides the plan's
    shown: Sequence[str] = ()  # keys of the columns that are printed; all where there are none


@dataclass(frozen=True, eq=False)
class SavedReport:
    """A report as its JSON file holds it, with all that made it."""

    format_version: int
    name: str
    title: str
    command: str
    said: list[str]
    claims: list[Claim]
    rows: list[dict[str, Any]]  # values as in a Report's
    figures: list[str]  # names of the files, without the ending
    data: str  # where the views are from
    runs: int
    seeds: list[int]
    fraction: float
    device: str
    precision: str
    settings: dict[str, Any]
    versions: dict[str, str]
    machine: dict[str, Any]


_SAVED = TypeAdapter(SavedReport)


def write(report: Report, plan: Plan, command: str) -> list[Path]:
    """Write NAME.csv, NAME.json and the figures into the plan's folder; the paths. Raises UnwritableOutput."""
    from orbitscan.processing.review.figures.style import save  # matplotlib is slow to import

    folder = plan.folder
    paths = [folder / f"{report.name}.csv", folder / f"{report.name}.json"]
    for name, figure in report.figures.items():
        paths += save(figure, folder / name)
    write_whole(paths[0], _csv(report.rows))
    write_whole(paths[1], json.dumps(asdict(_describe(report, plan, command)), indent=1) + "\n")
    return paths


def read(path: Path) -> SavedReport:
    """The report in a JSON file that `write` made. Raises InvalidOption for one of another version or study."""
    try:
        report = _SAVED.validate_json(path.read_bytes())
        if report.format_version == FORMAT_VERSION and report.name == path.stem:
            return report
    except (OSError, ValueError):
        pass
    raise InvalidOption(path, "is no report of this version", f"make it again: orbitscan reproduce {path.stem} -o DIR")


def _csv(rows: Sequence[Row]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def _describe(report: Report, plan: Plan, command: str) -> SavedReport:
    return SavedReport(
        format_version=FORMAT_VERSION,
        name=report.name,
        title=report.title,
        command=command,
        said=list(report.said),
        claims=list(report.claims),
        rows=[dict(row) for row in report.rows],
        figures=list(report.figures),
        data="virtual corpus" if plan.dataset is None else "Washington RGB-D Object dataset",
        runs=plan.runs,
        seeds=list(plan.seeds),
        fraction=plan.fraction,
        device=plan.device,
        precision=plan.precision,
        settings=dict(report.settings),
        versions={name: version(name) for name in ("orbitscan", *_LIBRARIES)},
        machine=_machine(plan.device),
    )


def _machine(device: str) -> dict[str, Any]:
    machine: dict[str, Any] = {"system": platform.platform(), "processor": platform.machine(), "cores": cpu_count()}
    if device.startswith("cuda"):
        import torch

        machine["gpu"] = torch.cuda.get_device_name(device)
    return machine
