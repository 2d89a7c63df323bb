"""A virtual depth camera that circles a mesh: exact poses, a known noise model, any number of points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.formats.mesh_file import read_mesh
from orbitscan.recorder.session import DEFAULT_VIEWS, Session, SessionInfo, View
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.raycasting import Scene
from orbitscan.recorder.simulation.sensors import DepthSensor, GaussianSensor, Kinect

MAX_PIXELS = 8_000_000  # of an image; more would not fit small machines' memory
DISTANCE = {"gaussian": 1.0, "kinect": 0.72}  # [m], of the camera where none is given
FOCAL = {"gaussian": 525.0, "kinect": 570.0}  # [pixels]


def simulate(
    what: str | Path,
    *,
    instance: int = 1,
    views: int = DEFAULT_VIEWS,
    elevation_deg: float = 30.0,
    distance: float | None = None,
    focal: float | None = None,
    noise_mm: float = 1.0,
    seed: int = 0,
    sensor: Literal["gaussian", "kinect"] = "gaussian",
    start_deg: float = 0.0,
    every: int = 1,
    name: str | None = None,
    threads: int = 0,
) -> Session:
    """One turn of a depth camera around an object of `objects` or a mesh file (STL, OBJ, PLY; metres, z up).

    The camera looks at the centre of the object's bounding box from `distance` [m] (None: the sensor's, or 2.5 radii
    of a large object), first from `start_deg` beside the front, +x, then in `views` equal steps counterclockwise about
    z seen from above, of which each `every`-th is recorded. `focal` is in pixels; the depth z has noise of
    sigma = noise_mm (z / 1 m)^2, white or as `sensor` makes it. Views are rendered when loaded, each from the seed and
    its place in the turn alone (a Kinect's: and from the session's name); `threads` cast their rays (0: all).
    Raises InvalidOption, and UnreadableCloud for a file that holds no mesh.
    """
    what, path = str(what), Path(what)
    from_file = what not in objects.names() and bool(path.suffix or path.exists())
    mesh = read_mesh(path) if from_file else objects.build(what, instance)
    low, high = mesh.bounds
    center = (low + high) / 2
    radius = float(np.linalg.norm(mesh.vertices - center, axis=1).max())
    distance = max(DISTANCE[sensor], 2.5 * radius) if distance is None else distance
    focal = FOCAL[sensor] if focal is None else focal
    _check_options(radius, views, every, elevation_deg, distance, focal, noise_mm, seed)
    name = name or (path.stem if from_file else what if instance == 1 else f"{what}_{instance}")
    if sensor == "kinect":
        if distance > Kinect.FAR:
            problem = f"a Kinect sees nothing beyond {Kinect.FAR:g} m"
            raise InvalidOption(f"--distance {distance:.3g}", problem, "give less, or --sensor gaussian")
        key = (seed, *name.encode())
        model = f"virtual Kinect ({distance:.3g} m, {focal:g} pixels, {noise_mm:g} mm, seed {seed})"
        device = Kinect.draw(np.random.default_rng(key), float(high[2] - low[2]), noise_mm / 1000)
    else:
        key, model, device = (seed,), "virtual depth camera", GaussianSensor(noise_mm / 1000)
    scene = Scene(mesh, threads)
    orbit = _Orbit(
        scene=scene,
        center=center,
        table=float(low[2]),
        distance=distance,
        elevation_deg=elevation_deg,
        views=len(range(0, views, every)),
        views_per_turn=views / every,
        every=every,
        focal=focal,
        half_image=_half_image(radius, distance, focal),
        sensor=device,
        key=key,
        start_deg=start_deg,
    )
    info = SessionInfo(
        name=name,
        views=orbit.views,
        category=None if from_file else what,
        instance=None if from_file else str(instance),
        source="virtual",
        sensor=f"{model}, rays cast by {scene.raycaster.name}",
        capture="circle",
        elevation_deg=elevation_deg,
        views_per_turn=orbit.views_per_turn,
    )
    return Session(info, tuple(_name(i) for i in range(orbit.views)), orbit.view, orbit.truth)


@dataclass(frozen=True, eq=False)
class _Orbit:
    """A depth camera on its circle around a mesh."""

    scene: Scene
    center: np.ndarray  # where the camera looks [m]
    table: float  # height of what the object stands on [m]
    distance: float  # from the centre to the camera [m]
    elevation_deg: float
    views: int
    views_per_turn: float
    every: int  # steps from view to view
    focal: float  # [pixels]
    half_image: int  # [pixels], of the bounding sphere's
    sensor: DepthSensor
    key: tuple[int, ...]  # of everything random
    start_deg: float  # azimuth of view 0, from the front

    def truth(self) -> Mapping[int, np.ndarray]:
        """T_object_camera of every view."""
        return {i: self.pose(i) for i in range(self.views)}

    def pose(self, index: int) -> np.ndarray:
        """T_object_camera: z towards the object's centre, x level."""
        azimuth = math.radians(self.start_deg + 360 * index / self.views_per_turn)
        elevation = math.radians(self.elevation_deg)
        level = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        outward = math.cos(elevation) * level + (0, 0, math.sin(elevation))
        right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
        return poses.make(
            np.column_stack([right, np.cross(right, outward), -outward]), self.center + self.distance * outward
        )

    def view(self, index: int) -> View:
        """What the camera sees from its place on the circle."""
        T_object_camera = self.pose(index)
        rng = np.random.default_rng([self.key[0], index * self.every, *self.key[1:]])
        columns, rows = self._pixels(T_object_camera)
        x, y = np.meshgrid(columns, rows)
        shape = x.shape
        if (shift := self.sensor.shift(shape, rng)) is None:
            directions = self._directions(T_object_camera, x, y)
        else:
            directions = self._directions(T_object_camera, x + shift[0] / self.focal, y + shift[1] / self.focal)
        hits = self.scene.cast(T_object_camera[:3, 3], directions)
        toward = -directions / np.linalg.norm(directions, axis=1, keepdims=True)
        facing = (toward * hits.normals).sum(axis=1)
        depth = self.sensor.measure(hits.distance.reshape(shape), np.abs(facing).reshape(shape), rng).ravel()
        height = T_object_camera[2, 3] + depth * directions[:, 2] - self.table
        seen = np.isfinite(depth) & (height > self.sensor.table_cut(rng))

        rays = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])[seen]
        points = (depth[seen, None] * rays).astype(np.float32)
        normals = hits.normals[seen] * np.sign(facing[seen, None])
        colors = self.scene.colors(hits.triangles[seen], hits.uv[seen], normals)
        return View(index, _name(index), (index + 1) * 10**9, points, colors)

    def _pixels(self, T_object_camera: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The columns' x and the rows' y at depth 1 of the pixels that may see the object."""
        low, high = np.full(2, -self.half_image), np.full(2, self.half_image)
        if self.sensor.margin is not None:
            seen = poses.transform(poses.invert(T_object_camera), self.scene.mesh.vertices)
            places = self.focal * seen[:, :2] / seen[:, 2:]
            low = np.floor(places.min(axis=0)).astype(int) - self.sensor.margin
            high = np.ceil(places.max(axis=0)).astype(int) + self.sensor.margin
        columns, rows = ((np.arange(*ends) + 0.5) / self.focal for ends in zip(low, high, strict=True))
        return columns, rows

    @staticmethod
    def _directions(T_object_camera: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(N, 3) rays in the object's frame; of depth 1, so that a hit's distance is its depth."""
        rays = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])
        return poses.rotate(T_object_camera, rays)


def _name(index: int) -> str:
    return f"view_{index:03d}"


def _half_image(radius: float, distance: float, focal: float) -> int:
    """Half the side [pixels] of the image that holds the object's bounding sphere; 240 at most by default."""
    return math.ceil(focal * radius / math.sqrt(distance**2 - radius**2))


def _check_options(
    radius: float,
    views: int,
    every: int,
    elevation_deg: float,
    distance: float,
    focal: float,
    noise_mm: float,
    seed: int,
) -> None:
    """Raise InvalidOption for the first value that makes no sense for an object of the radius."""
    if views < 1:
        raise InvalidOption(f"--views {views}", "a turn has at least one view", "give 1 or more")
    if every < 1:
        raise InvalidOption(f"--every {every}", "no step from view to view", "give 1 or more")
    if not -90 <= elevation_deg <= 90:
        raise InvalidOption(f"--elevation {elevation_deg:g}", "no angle above the horizon", "give -90 to 90 degrees")
    if not math.isfinite(distance):
        raise InvalidOption(f"--distance {distance:g}", "no distance", "give metres, or leave it out")
    if distance <= radius:
        problem = f"the camera would stand inside the object, which reaches {radius:.3g} m from its centre"
        raise InvalidOption(f"--distance {distance:g}", problem, "give more, or leave it out")
    if not 0 < focal < math.inf:
        raise InvalidOption(f"--focal {focal:g}", "no focal length", "give pixels, such as 525")
    if not 0 <= noise_mm < math.inf:
        raise InvalidOption(f"--noise-mm {noise_mm:g}", "no standard deviation", "give 0 or more")
    if seed < 0:
        raise InvalidOption(f"--seed {seed}", "seeds are not negative", "give 0 or more")
    if (pixels := (2 * _half_image(radius, distance, focal)) ** 2) > MAX_PIXELS:
        problem = f"the object would fill an image of {pixels / 1e6:.0f} megapixels (at most {MAX_PIXELS / 1e6:.0f})"
        raise InvalidOption(f"--focal {focal:g}", problem, "give a shorter --focal or a longer --distance")
