"""The sessions that are registered: a case names everything that makes one, `build` makes it with all its truth."""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from scipy.spatial.transform import Rotation

from orbitscan.recorder import poses
from orbitscan.recorder.session import Session, in_memory
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.camera import Camera, simulate
from tests.benchmarks import scene as scenes
from tests.benchmarks.floor import Information, inform, pair_variance
from tests.benchmarks.scene import Scene

OBJECTS = (
    "robot", "bin", "statue", "helicopter", "vacuum_cleaner",
    "coffee_mug", "cap", "pliers", "bowl", "water_bottle",
)  # fmt: skip
ASYMMETRIC = ("robot", "statue", "helicopter", "vacuum_cleaner")  # nobody may call a motion of these free
FOCAL = 525.0  # [pixels]
UNEVEN_DEG = 8.0  # by which a step of an uneven path is more or less, at most
ELEVATIONS_DEG = 10.0, 60.0  # between which random viewpoints lie
Path = Literal["turn", "uneven", "random"]  # equal steps, steps of a hand, viewpoints anywhere in no order
MIN_POINTS = 5000  # of a view, about: where the usual focal length gives fewer, it is longer


@dataclass(frozen=True)
class Case:
    """All that makes a session; the object's instance is seed + 1."""

    object: str
    step: int  # degrees between successive views
    noise: float = 1.0  # of the depth at 1 m [mm]
    seed: int = 0
    random_frames: bool = False  # every view turned at random about the sensor: the start is unknown
    size: float | None = None  # the object's diameter [m], noise and all scaled with it; None: as built
    points: int | None = None  # of a view, about, by the focal length; None: what the usual one gives
    views: int | None = None  # only the first ones; None: the whole turn
    outliers: float = 0.01  # share of the points put anywhere in the view's bounding box
    path: Path = "turn"  # of the camera, from view to view

    def __str__(self) -> str:
        extras = [f"{self.points} points" * bool(self.points), f"{self.size} m" * bool(self.size)]
        extras += ["random frames" * self.random_frames, f"{self.path} path" * (self.path != "turn")]
        return ", ".join(filter(None, [f"{self.object} {self.step} deg {self.noise:g} mm seed {self.seed}", *extras]))


@dataclass(frozen=True, eq=False)
class Seen:
    """What a view truly sees, point by point, outliers left out; in the object's frame, metres."""

    points: np.ndarray  # (N, 3) on the surface, no noise
    normals: np.ndarray  # (N, 3) of the surface, towards the camera
    facets: np.ndarray  # (N, 3) of the mesh's facets, on which it depends how densely a camera measures
    variance: np.ndarray  # (N,) of the measured points along the normal [m^2]


@dataclass(frozen=True, eq=False)
class Scan:
    """A session with all its truth."""

    case: Case
    session: Session
    seen: tuple[Seen, ...]  # of every view
    diameter: float  # of the object [m]
    center: np.ndarray  # (3,) mean of all that is seen, in the object's frame
    scene: Scene
    focal: float
    scale: float  # from the object as built
    T_object_camera: tuple[np.ndarray, ...]  # as rendered: neither scaled nor turned

    def overlap(self, source: int, target: int) -> Information | None:
        """What the true overlap of two views says about the pose between them; None where there is (almost) none."""
        seen, T = self.seen[source], self.T_object_camera[target]
        points = seen.points / self.scale
        common = self.scene.visible(T[:3, 3], points)
        here, there = (self.density(seen, view) for view in (source, target))
        common &= (here > 0) & (there > 0)
        if common.sum() < 6:
            return None
        local = poses.transform(poses.invert(T), points)
        noise = self.scale**2 * _variance_along(local, seen.normals @ T[:3, :3], self.case.noise)
        variance = pair_variance(*(values[common] for values in (seen.variance, noise, here, there)))
        return inform(seen.points[common], seen.normals[common], variance)

    def localized(self, view: int, lever: float) -> Information:
        """What a view says about its own pose where the surface is known."""
        seen = self.seen[view]
        return inform(seen.points, seen.normals, seen.variance, self.center, lever)

    def density(self, seen: Seen, view: int) -> np.ndarray:
        """(N,) how densely a view measures seen points, were nothing in between."""
        T = self.T_object_camera[view]
        points = poses.transform(poses.invert(T), seen.points / self.scale)
        return scenes.density(points, seen.facets @ T[:3, :3], self.focal)


def available() -> tuple[str, ...]:
    """The objects of the benchmark that can be built."""
    return tuple(name for name in OBJECTS if name in objects.names())


@lru_cache(maxsize=3)
def build(case: Case) -> Scan:
    """The session of a case and its truth; the last few are kept."""
    instance = case.seed + 1
    scene = scenes.of_object(case.object, instance)
    focal = _focal_for(case.object, instance, case.points)
    scale = 1.0 if case.size is None else case.size / scene.diameter
    count = round(360 / case.step)
    rendered = _render(case, count, instance=instance, noise_mm=case.noise, focal=focal)
    indices = range(min(count, case.views or count))
    views, truth, seen = [], {}, []
    for i in indices:
        view, T_object_camera = rendered.load(i), rendered.truth()[i]
        points, replaced = _with_outliers(view.points, case, i)
        R = Rotation.random(random_state=np.random.default_rng([case.seed, i, 2])) if case.random_frames else None
        turn = poses.make(np.eye(3) if R is None else R.as_matrix(), np.zeros(3))
        views.append(replace(view, points=(scale * poses.transform(turn, points)).astype(np.float32), colors=None))
        T = T_object_camera @ poses.invert(turn)
        truth[i] = poses.make(T[:3, :3], scale * T[:3, 3])
        seen.append(_see(scene, T_object_camera, view.points[~replaced], case.noise, scale))
    return Scan(
        case=case,
        session=in_memory(rendered.info, views, truth),
        seen=tuple(seen),
        diameter=scale * scene.diameter,
        center=np.concatenate([s.points for s in seen]).mean(axis=0),
        scene=scene,
        focal=focal,
        scale=scale,
        T_object_camera=tuple(rendered.truth()[i] for i in indices),
    )


def _render(case: Case, count: int, **how: Any) -> Session:
    """The session before anything is done to its points."""
    if case.path == "turn":
        return simulate(case.object, views=count, seed=case.seed, **how)
    generator = np.random.default_rng([case.seed, 3])
    if case.path == "uneven":
        steps = generator.uniform(case.step - UNEVEN_DEG, case.step + UNEVEN_DEG, count)
        places = [(azimuth, 30.0) for azimuth in np.cumsum(steps)]
    else:
        places = list(zip(generator.uniform(0, 360, count), generator.uniform(*ELEVATIONS_DEG, count), strict=True))
    views, truth = [], {}
    for i, (azimuth, elevation) in enumerate(places):
        camera = Camera(views=1, start_deg=azimuth, elevation_deg=elevation, seed=1000 * case.seed + i)
        alone = simulate(case.object, camera=camera, **how)
        views.append(replace(alone.load(0), index=i, name=f"view_{i:03d}"))
        truth[i] = alone.truth()[0]
    info = replace(alone.info, views=count, capture="unknown", elevation_deg=None, views_per_turn=None)
    return in_memory(info, views, truth)


def _with_outliers(points: np.ndarray, case: Case, index: int) -> tuple[np.ndarray, np.ndarray]:
    """The points with a share of them put anywhere in their bounding box, and which those are."""
    generator = np.random.default_rng([case.seed, index, 1])
    replaced = generator.random(len(points)) < case.outliers
    anywhere = generator.uniform(points.min(axis=0), points.max(axis=0), (int(replaced.sum()), 3))
    points = points.astype(np.float64)
    points[replaced] = anywhere
    return points, replaced


def _see(scene: Scene, T_object_camera: np.ndarray, measured: np.ndarray, noise: float, scale: float) -> Seen:
    """The truth of measured points (N, 3): noise moves them along their ray, so the ray finds where they were."""
    points, normals, facets = scene.surface(T_object_camera[:3, 3], poses.transform(T_object_camera, measured))
    met = np.isfinite(points).all(axis=1)
    points, normals, facets = points[met], normals[met], facets[met]
    local = poses.transform(poses.invert(T_object_camera), points)
    variance = _variance_along(local, normals @ T_object_camera[:3, :3], noise)
    return Seen(scale * points, normals, facets, scale**2 * variance)


def _variance_along(points: np.ndarray, normals: np.ndarray, noise: float) -> np.ndarray:
    """(N,) variance along the normals [m^2] of points in a camera's frame.

    The depth z varies by sigma = noise z^2 and the point moves along its ray, by sigma (x, y, z) / z. Without noise
    all variances are those of 1 mm: the information then still tells which motions are free.
    """
    sigma = (noise or 1.0) / 1000 * points[:, 2] ** 2
    return (sigma * (points * normals).sum(axis=1) / points[:, 2]) ** 2


@lru_cache(maxsize=64)
def _focal_for(name: str, instance: int, points: int | None) -> float:
    """The focal length [pixels] that gives so many points a view, about."""
    usual = simulate(name, instance=instance, views=3, noise_mm=0, focal=FOCAL)
    found = float(np.mean([len(view.points) for view in usual.views()]))
    wanted = max(found, MIN_POINTS) if points is None else points
    return FOCAL * float(np.sqrt(wanted / found))
