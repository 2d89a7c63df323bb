"""A prepared view: its finite points, and the working cloud with normals that every later step looks at."""

from dataclasses import dataclass

import numpy as np

from processing.features import grid
from processing.features.normals import estimate_normals
from recorder import cloud
from recorder.session import View, Views


@dataclass(frozen=True)
class SurfaceSettings:
    """How a view is prepared; no value is in the thesis."""

    noise_factor: float = 1.5  # the working resolution is at least this times the noise ...
    diameter_share: float = 1 / 150  # ... and at least this share of the object's diameter
    scale_views: int = 5  # views looked at to choose it
    normal_radius: float = 4.0  # multiples of the working resolution
    min_points: int = 50  # fewer working points cannot be registered


@dataclass(frozen=True)
class Scale:
    """The sizes of a scan, the same for all its views: descriptors of unequal radius cannot be compared."""

    working: float  # resolution w of the working clouds [m]
    noise: float  # standard deviation of a point along the surface's normal [m]
    diameter: float  # of a view [m]


@dataclass(frozen=True, eq=False)
class Surface:
    """A view, ready for registration."""

    view: int
    points: np.ndarray  # (N, 3) float32, all finite points
    colors: np.ndarray | None  # (N, 3) uint8
    working: np.ndarray  # (M, 3) float64, one point in a cell of side w
    normals: np.ndarray  # (M, 3) float64, towards the sensor; NaN where there are too few neighbours
    enough: bool  # whether there are points enough to register


def choose_scale(views: Views, settings: SurfaceSettings) -> Scale | None:
    """The median sizes of a few views over the whole session; None where no view has points enough."""
    step = max(1, len(views) // settings.scale_views)
    facts = [_facts(views.load(index), settings) for index in views.indices[::step]]
    facts = [f for f in facts if f] or [f for f in (_facts(view, settings) for view in views) if f]
    if not facts:
        return None
    resolution, noise, diameter = np.median([(f.resolution, f.noise, f.diameter) for f in facts], axis=0)
    working = max(resolution, settings.noise_factor * noise, settings.diameter_share * diameter)
    return Scale(float(working), float(noise), float(diameter)) if working > 0 else None


def _facts(view: View, settings: SurfaceSettings) -> cloud.CloudFacts | None:
    points, _ = cloud.finite(view.points)
    return cloud.measure(points) if len(points) >= settings.min_points else None


def prepare(
    view: View, scale: Scale | None, sensor_origin: tuple[float, ...] | None, settings: SurfaceSettings
) -> Surface:
    """The surface of a view at a scan's scale; normals face the sensor's origin (see `estimate_normals`)."""
    points, colors = cloud.finite(view.points, view.colors)
    working = grid.cell_means(points, scale.working) if scale else np.empty((0, 3))
    if len(working) < settings.min_points:
        return Surface(view.index, points, colors, working, np.full_like(working, np.nan), False)
    radius = settings.normal_radius * scale.working
    origin = None if sensor_origin is None else np.array(sensor_origin, dtype=np.float64)
    normals = estimate_normals(working, radius, origin)
    return Surface(view.index, points, colors, working, normals, True)
