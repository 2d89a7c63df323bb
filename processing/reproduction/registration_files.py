"""What the registration left in its folders, of the first run: the errors of every frame, and the models."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from recorder.sources import ply_file

FOLDER = "registration"  # / the way it was registered / the circle of views / what `process` writes
FIRST_RUN = "-seed-0"  # ends the name of a circle
DENSE = "-dense-"  # is in the name of a circle of which figure 5.9 shows no model
QUANTITIES = ("translation_error_m", "rotation_error_chordal", "center_error_m")


def read_frames(folder: Path) -> list[dict[str, Any]]:
    """A row for each circle, method and view: its errors, None where there is no estimate."""
    rows = []
    for way, circle, results in _find_results(folder):
        path = results / "errors.csv"
        if not path.exists():
            continue
        with path.open(encoding="utf-8", newline="") as stream:
            table = list(csv.DictReader(stream))
        alone = len({line["method"] for line in table}) == 1  # then the way's name tells more
        rows += [
            {"circle": circle, "method": way if alone else line["method"], "view": int(line["view"])}
            | {name: float(line[name]) if line[name] else None for name in QUANTITIES}
            for line in table
        ]
    return rows


def read_models(folder: Path) -> dict[str, dict[str, tuple[np.ndarray, np.ndarray | None]]]:
    """Circle -> way -> the points (N, 3) and colours of its model; circles of few views only."""
    models: dict[str, dict[str, tuple[np.ndarray, np.ndarray | None]]] = {}
    for way, circle, results in _find_results(folder):
        if DENSE not in circle and (path := results / "model.ply").exists():
            models.setdefault(circle, {})[way] = ply_file.read(path)
    return models


def _find_results(folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Way, circle and folder of each result of the first run."""
    for results in sorted((folder / FOLDER).glob(f"*/*{FIRST_RUN}")):
        yield results.parent.name, results.name.removesuffix(FIRST_RUN), results
