"""The classifiers the thesis compares its network with (table 5.3): descriptors matched exhaustively with known views'.

SHOT, FPFH and PFH describe the places of a 1 cm voxel grid, ESF the whole cloud. "The class with the best set of
matches wins": every descriptor of a query is matched with its nearest in each category; the least mean distance wins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Literal, get_args

import numpy as np

from orbitscan.processing.features import esf, fpfh, pfh, shot
from orbitscan.processing.kernels.grid import cell_means
from orbitscan.processing.surface.normals import estimate_normals
from orbitscan.recorder.cloud import finite
from orbitscan.recorder.exceptions import InvalidOption

Kind = Literal["shot", "fpfh", "pfh", "esf"]
KINDS: tuple[Kind, ...] = get_args(Kind)
LENGTHS = {"shot": shot.LENGTH, "fpfh": fpfh.LENGTH, "pfh": pfh.LENGTH, "esf": esf.LENGTH}
CAMERA = (0.0, 0.0, 0.0)
_QUERIES, _KNOWN = 1024, 8192  # descriptors compared at once: 32 MB of distances


@dataclass(frozen=True)
class DescriptorSettings:
    """Sizes in metres; but for the keypoints' spacing, no value is in the thesis."""

    keypoint_spacing: float = 0.01  # thesis, table 5.3: one keypoint in a voxel
    surface_spacing: float = 0.004  # of the points that count as neighbours
    normal_radius: float = 0.012
    shot_radius: float = 0.05
    fpfh_radius: float = 0.03
    pfh_radius: float = 0.03  # the time grows with its fourth power
    seed: int = 0  # of ESF's triangles, the same for every view


@dataclass(frozen=True, eq=False)
class Database:
    """All descriptors of the known views, category by category."""

    kind: Kind
    settings: DescriptorSettings
    categories: tuple[str, ...]
    descriptors: np.ndarray  # (N, D) float32
    classes: np.ndarray  # (N,) int64, ascending: index into `categories`


@dataclass(frozen=True, eq=False)
class Answers:
    """What several views were taken for, and the time it took."""

    categories: tuple[str | None, ...]  # of each view; None where nothing could be described
    distances: np.ndarray  # (V, C) float32 from each category, the least wins; NaN where there is no answer
    description_s: float
    search_s: float


def describe_view(
    points: np.ndarray,
    sensor_origin: np.ndarray | Sequence[float] | None,
    kind: Kind,
    settings: DescriptorSettings | None = None,
) -> np.ndarray:
    """The descriptors (K, D) float32 of a view's points (N, 3) [m]: of its keypoints, or for ESF of all; K may be 0.

    Normals face the sensor's origin (3,) [m] (None: see `estimate_normals`). Places without neighbours enough have no
    descriptor. Raises InvalidOption for an unknown kind, and MissingLibrary where FPFH's does not load.
    """
    if kind not in KINDS:
        raise InvalidOption(kind, "no known descriptor", f"choose one of {', '.join(KINDS)}")
    settings = settings or DescriptorSettings()
    points, _ = finite(points)
    if not len(points):
        return np.empty((0, LENGTHS[kind]), np.float32)
    if kind == "esf":
        return _described(esf.describe(points, settings.seed)[None])
    surface = cell_means(points, settings.surface_spacing)
    keypoints = cell_means(points, settings.keypoint_spacing)
    origin = None if sensor_origin is None else np.asarray(sensor_origin, dtype=np.float64)
    normals = estimate_normals(surface, settings.normal_radius, origin)
    if kind == "shot":
        return _described(shot.describe(surface, normals, keypoints, settings.shot_radius)[0])
    if kind == "fpfh":
        return _described(fpfh.describe(surface, normals, keypoints, settings.fpfh_radius))
    return _described(pfh.describe(surface, normals, keypoints, settings.pfh_radius))


def build_database(
    clouds: Sequence[np.ndarray],
    categories: Sequence[str],
    kind: Kind,
    settings: DescriptorSettings | None = None,
    sensor_origin: np.ndarray | Sequence[float] | None = CAMERA,
) -> Database:
    """The database of known views: their points (N, 3) [m] and what each shows.

    Raises InvalidOption where they are not as many, or nothing can be described, and what describing raises.
    """
    if len(clouds) != len(categories):
        raise InvalidOption(f"{len(clouds)} views", f"have {len(categories)} categories", "give one for each")
    settings = settings or DescriptorSettings()
    described = [describe_view(points, sensor_origin, kind, settings) for points in clouds]
    names = tuple(sorted({name for name, rows in zip(categories, described, strict=True) if len(rows)}))
    if not names:
        raise InvalidOption("the views to compare with", f"have nothing that {kind} describes", "give others")
    order = sorted((i for i in range(len(clouds)) if len(described[i])), key=lambda i: names.index(categories[i]))
    classes = np.repeat([names.index(categories[i]) for i in order], [len(described[i]) for i in order])
    return Database(kind, settings, names, np.concatenate([described[i] for i in order]), classes)


def classify_views(
    database: Database,
    clouds: Sequence[np.ndarray],
    sensor_origin: np.ndarray | Sequence[float] | None = CAMERA,
    device: str = "cpu",
) -> Answers:
    """What views, by their points (N, 3) [m], are taken for; all their descriptors search the database together.

    A view's distance from a category is the mean over its descriptors of that to the category's nearest, so that a
    category with more known views has no more votes (Boiman et al., In defense of nearest-neighbor based image
    classification, CVPR 2008).
    """
    begin = perf_counter()
    described = [describe_view(points, sensor_origin, database.kind, database.settings) for points in clouds]
    middle = perf_counter()
    counts = [len(rows) for rows in described]
    distances = np.full((len(clouds), len(database.categories)), np.nan, np.float32)
    if any(counts):
        nearest = nearest_distances(database, np.concatenate(described), device)
        for i, rows in enumerate(np.split(nearest, np.cumsum(counts)[:-1])):
            if len(rows):
                distances[i] = rows.mean(axis=0)
    best = [database.categories[int(row.argmin())] if np.isfinite(row[0]) else None for row in distances]
    return Answers(tuple(best), distances, middle - begin, perf_counter() - middle)


def nearest_distances(database: Database, descriptors: np.ndarray, device: str = "cpu") -> np.ndarray:
    """The distance (K, C) float32 of every descriptor (K, D) to its nearest of each category, by comparing with all.

    Euclidean; of ESF's, as its authors compare them, the sum of absolute differences. Which one is nearest is told in
    float32, to about a thousandth of a descriptor's length.
    """
    import torch

    known, queries = (torch.from_numpy(rows).to(device) for rows in (database.descriptors, descriptors))
    norm = 1 if database.kind == "esf" else 2
    bounds = np.searchsorted(database.classes, np.arange(len(database.categories) + 1)).tolist()
    distances = torch.empty((len(queries), len(database.categories)), device=device)
    for some, out in zip(queries.split(_QUERIES), distances.split(_QUERIES), strict=True):
        for c in range(len(database.categories)):
            least = torch.full((len(some),), torch.inf, device=device)
            nearest = torch.zeros(len(some), dtype=torch.int64, device=device)
            for start in range(bounds[c], bounds[c + 1], _KNOWN):
                found = torch.cdist(some, known[start : min(start + _KNOWN, bounds[c + 1])], p=norm).min(dim=1)
                closer = found.values < least
                least = torch.where(closer, found.values, least)
                nearest = torch.where(closer, start + found.indices, nearest)
            out[:, c] = torch.linalg.vector_norm(some - known[nearest], ord=norm, dim=1)  # cdist's are less exact
    return distances.cpu().numpy()


def _described(descriptors: np.ndarray) -> np.ndarray:
    """The rows that describe something: neither NaN nor all zero."""
    return descriptors[np.isfinite(descriptors).all(axis=1) & descriptors.any(axis=1)]
