"""What the registration left in its folders, of the first run: the errors of every frame, and the models."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from orbitscan.recorder.formats import ply

FOLDER = "registration"  # / the way it was registered / the circle of views / what `process` writes
FIRST_RUN = "-seed-0"  # ends the name of a circle
DENSE = "-dense-"  # is in the name of a circle of which figure 5.9 shows no model
WAYS = ("icp", "ransac_icp", "identity", "ours")  # in the order they are shown; others after them
ELEVATION_DEG = 30.0  # from which the first camera looks down on its object
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
    """Circle -> way -> the points (N, 3), z up, and colours of its model; circles of few views only."""
    models: dict[str, dict[str, tuple[np.ndarray, np.ndarray | None]]] = {}
    for way, circle, results in _find_results(folder):
        if DENSE not in circle and (path := results / "model.ply").exists():
            points, colors = ply.read(path)
            models.setdefault(circle, {})[way] = (_set_upright(points), colors)
    return models


def _set_upright(points: np.ndarray) -> np.ndarray:
    """Points (N, 3) of the first camera's frame in one with x to its right, y level and away from it, z up."""
    cos, sin = np.cos(np.radians(ELEVATION_DEG)), np.sin(np.radians(ELEVATION_DEG))
    upright = np.array([[1.0, 0.0, 0.0], [0.0, -sin, cos], [0.0, -cos, -sin]])
    return points @ upright.T.astype(np.float32)


def _find_results(folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Way, circle and folder of each result of the first run; circles of few views first."""
    found = (folder / FOLDER).glob(f"*/*{FIRST_RUN}")
    for results in sorted(found, key=lambda path: (DENSE in path.name, path.name, _rank(path.parent.name))):
        yield results.parent.name, results.name.removesuffix(FIRST_RUN), results


def _rank(way: str) -> tuple[int, str]:
    return WAYS.index(way) if way in WAYS else len(WAYS), way
