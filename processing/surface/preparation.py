"""A prepared view: its finite points, the working cloud with normals, and the surface fitted to it."""

from dataclasses import dataclass

import numpy as np

from orbitscan.processing.kernels import grid
from orbitscan.processing.surface.normals import estimate_normals
from orbitscan.processing.surface.quadric import fit_quadrics
from orbitscan.recorder import cloud
from orbitscan.recorder.session import View, Views


@dataclass(frozen=True)
class SurfaceSettings:
    """How a view is prepared; no value is in the thesis."""

    noise_factor: float = 2.5  # the working resolution w is at least this times the noise ...
    diameter_share: float = 1 / 150  # ... and at least this share of the object's diameter
    scale_views: int = 5  # spread over the session, looked at to choose it; up to twice as many
    normal_radius: float = 4.0  # multiples of w
    quadric_radius: float = 2.0  # the same, and at least as far as 32 neighbours reach
    min_points: int = 50  # fewer working points cannot be registered
    kept_views: int = 40  # prepared views held in memory; others are prepared again when they are needed


@dataclass(frozen=True)
class Scale:
    """The sizes of a scan, the same for all its views: descriptors of unequal radius cannot be compared."""

    working: float  # resolution w of the working clouds [m]
    patch: float  # how far a neighbourhood of 32 points reaches in the clouds [m]
    noise: float  # standard deviation of a point along the surface's normal [m]
    diameter: float  # of the object as a view sees it [m]


UNKNOWN_SCALE = Scale(np.nan, np.nan, np.nan, np.nan)  # of a scan without a view that has points enough


@dataclass(frozen=True, eq=False)
class Surfels:
    """Points on a surface, denoised by quadrics fitted to all points of the view (see `fit_quadrics`)."""

    points: np.ndarray  # (S, 3) float64
    normals: np.ndarray  # (S, 3) float64, unit, towards the sensor
    variances: np.ndarray  # (S,) [m^2] of the view's points about the surface, along the normal

    def __len__(self) -> int:
        return len(self.points)

    def every(self, most: int) -> slice:
        """Which surfels `thinned` returns."""
        return slice(None, None, max(1, -(-len(self) // most)))

    def thinned(self, most: int) -> "Surfels":
        """Return every n-th surfel, `most` at most; contiguous, so that kernels are compiled for one layout only."""
        step = self.every(most)
        return Surfels(*map(np.ascontiguousarray, (self.points[step], self.normals[step], self.variances[step])))


@dataclass(frozen=True, eq=False)
class Surface:
    """A view, ready for registration."""

    view: int
    points: np.ndarray  # (N, 3) float32, all finite points
    colors: np.ndarray | None  # (N, 3) uint8
    working: np.ndarray  # (M, 3) float64, one point in a cell of side w
    normals: np.ndarray  # (M, 3) float64, towards the sensor; NaN where there are too few neighbours
    surfels: Surfels  # the working points whose surface can be told
    reach: float  # of the neighbourhoods they are fitted to [m]
    sensor_origin: np.ndarray | None  # (3,) metres, None where unknown
    enough: bool  # whether there are points enough to register
    outline_known: bool = False  # whether nothing is where no point is: those directions were looked at


def choose_scale(views: Views, settings: SurfaceSettings) -> Scale | None:
    """Choose the median sizes of a few views over the whole session; None where no view has points enough."""
    step = max(1, len(views) // settings.scale_views)
    some = [_measure(views.load(index), settings) for index in views.indices[::step]]
    facts = [f for f in some if f] or [f for f in (_measure(view, settings) for view in views) if f]
    if not facts:
        return None
    sizes = np.median([(f.resolution, f.patch, f.noise, f.diameter) for f in facts], axis=0)
    resolution, patch, noise, diameter = map(float, sizes)
    working = max(resolution, settings.noise_factor * noise, settings.diameter_share * diameter)
    return Scale(working, patch, noise, diameter) if working > 0 else None


def _measure(view: View, settings: SurfaceSettings) -> cloud.CloudFacts | None:
    points, _ = cloud.finite(view.points)
    return cloud.measure(points) if len(points) >= settings.min_points else None


def prepare(
    view: View,
    scale: Scale | None,
    sensor_origin: tuple[float, ...] | None,
    settings: SurfaceSettings,
    outline_known: bool = False,
) -> Surface:
    """Prepare the surface of a view at a scan's scale; normals face the sensor's origin (see `estimate_normals`).

    `outline_known`: see `SessionInfo`. Without normals and surfels where there are too few points, or no scale.
    """
    points, colors = cloud.finite(view.points, view.colors)
    origin = None if sensor_origin is None else np.array(sensor_origin, dtype=np.float64)
    working = grid.cell_means(points, scale.working) if scale else np.empty((0, 3))
    if scale is None or len(working) < settings.min_points:
        nothing = Surfels(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
        return Surface(
            view.index, points, colors, working, np.full_like(working, np.nan), nothing, np.nan, origin, False
        )
    normals = estimate_normals(working, settings.normal_radius * scale.working, origin)
    radius = max(settings.quadric_radius * scale.working, scale.patch)
    fitted, turned, variances = fit_quadrics(working, normals, points, radius)
    known = np.isfinite(variances)
    surfels = Surfels(fitted[known], turned[known], variances[known])
    enough = len(surfels) >= settings.min_points
    return Surface(view.index, points, colors, working, normals, surfels, radius, origin, enough, outline_known)
