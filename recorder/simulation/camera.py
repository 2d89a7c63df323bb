"""A virtual depth camera that circles a mesh: exact poses, a known noise model, any number of points."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidOption, Wording, setting
from orbitscan.recorder.formats.mesh_file import read_mesh
from orbitscan.recorder.session import DEFAULT_VIEWS, Session, SessionInfo, View
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.appearance import LAMPS, PAINTS, Appearance, Lamp, Paint, add_noise, toward
from orbitscan.recorder.simulation.raycasting import Scene
from orbitscan.recorder.simulation.sensors import DepthSensor, GaussianSensor, Kinect

MAX_PIXELS = 8_000_000  # of an image; more would not fit small machines' memory
DISTANCE = {"gaussian": 1.0, "kinect": 0.72}  # [m], of the camera where none is given
FOCAL = {"gaussian": 525.0, "kinect": 570.0}  # [pixels]
_COLORS = 1  # tells the random numbers of colours from those of depths


@dataclass(frozen=True)
class Camera:
    """A depth camera on one turn around an object, whose bounding box's centre it looks at.

    It goes in equal steps counterclockwise about z seen from above. The depth z has noise of
    sigma = noise_mm (z / 1 m)^2, white or as the sensor makes it. Raises InvalidOption for what cannot be.
    """

    views: int = DEFAULT_VIEWS  # in the turn
    every: int = 1  # of these, each n-th is recorded
    elevation_deg: float = 30.0  # above the object
    start_deg: float = 0.0  # azimuth of view 0, from the object's front, +x
    sensor: Literal["gaussian", "kinect"] = "gaussian"
    distance: float | None = None  # from the centre [m]; None: the sensor's, or 2.5 radii of a large object
    focal: float | None = None  # [pixels]; None: the sensor's
    noise_mm: float = 1.0
    paint: Paint = "own"  # the object's own colours, or what is painted on it
    lamp: Lamp = "object"  # stands still beside the object, at the camera, or in the room while the object turns
    gloss: float = 0.0  # brightness of a highlight, as a share of white
    color_noise: float = 0.0  # standard deviation of each channel, of 255
    color_shift: float = 0.0  # pixels by which colours lie beside the depths that they belong to
    seed: int = 0
    threads: int = 0  # that cast the rays; 0: all

    def __post_init__(self) -> None:
        distance, focal = 1.0 if self.distance is None else self.distance, 1.0 if self.focal is None else self.focal
        for name, possible, problem, remedy in (
            ("views", self.views >= 1, "a turn has at least one view", "give 1 or more"),
            ("every", self.every >= 1, "not a step from view to view", "give 1 or more"),
            ("elevation_deg", abs(self.elevation_deg) <= 90, "not an elevation", "give -90 to 90 degrees"),
            ("sensor", self.sensor in FOCAL, "not a known sensor", f"give {' or '.join(FOCAL)}"),
            ("distance", 0 < distance < math.inf, "not a distance", "give metres, or leave it out"),
            ("focal", 0 < focal < math.inf, "not a focal length", "give pixels, such as 525"),
            ("noise_mm", 0 <= self.noise_mm < math.inf, "not a standard deviation", "give 0 or more"),
            ("paint", self.paint in PAINTS, "nothing that can be painted", f"give {_any_of(PAINTS)}"),
            ("lamp", self.lamp in LAMPS, "no lamp", f"give {_any_of(LAMPS)}"),
            ("gloss", 0 <= self.gloss <= 1, "not a share", "give 0 to 1"),
            ("color_noise", 0 <= self.color_noise < math.inf, "not a standard deviation", "give 0 or more"),
            ("color_shift", math.isfinite(self.color_shift), "not a number of pixels", "give 0, or a few pixels"),
            ("seed", self.seed >= 0, "seeds are not negative", "give 0 or more"),
        ):
            if not possible:
                raise InvalidOption(setting(name, getattr(self, name)), problem, remedy)

    @property
    def recorded_views(self) -> int:
        """How many views are recorded."""
        return len(range(0, self.views, self.every))


def simulate(
    what: str | Path, instance: int = 1, camera: Camera | None = None, *, name: str | None = None, **changes: Any
) -> Session:
    """One turn of a depth camera around an object of `objects` or a mesh file (STL, OBJ, PLY; metres, z up).

    `changes` are fields of the camera, by name: `simulate("robot", views=9)`. Views are rendered when they are loaded,
    each from the seed and its place in the turn alone (a Kinect's: and from the session's name). Raises InvalidOption,
    and UnreadableCloud for a file that holds no mesh.
    """
    camera = replace(camera or Camera(), **changes)
    what, path = str(what), Path(what)
    from_file = what not in objects.names() and bool(path.suffix or path.exists())
    mesh = read_mesh(path) if from_file else objects.build(what, instance)
    low, high = mesh.bounds
    center = (low + high) / 2
    radius = float(np.linalg.norm(mesh.vertices - center, axis=1).max())
    distance = max(DISTANCE[camera.sensor], 2.5 * radius) if camera.distance is None else camera.distance
    focal = FOCAL[camera.sensor] if camera.focal is None else camera.focal
    half_image = _half_image(radius, distance, focal)
    name = name or (path.stem if from_file else what if instance == 1 else f"{what}_{instance}")
    noise, seed = camera.noise_mm / 1000, camera.seed
    key: tuple[int, ...]
    device: DepthSensor
    if camera.sensor == "kinect":
        if distance > Kinect.FAR:
            subject = setting("distance", float(f"{distance:.3g}"))
            remedy = Wording("give less, or {sensor}", sensor="gaussian")
            raise InvalidOption(subject, f"a Kinect sees nothing beyond {Kinect.FAR:g} m", remedy)
        key = (seed, *name.encode())
        model = f"virtual Kinect ({distance:.3g} m, {focal:g} pixels, {camera.noise_mm:g} mm, seed {seed})"
        device = Kinect.draw(np.random.default_rng(key), float(high[2] - low[2]), noise)
    else:
        key, model, device = (seed,), "virtual depth camera", GaussianSensor(noise)
    scene = Scene(mesh, camera.threads)
    looks = Appearance(mesh, camera.paint, camera.lamp, camera.gloss)
    orbit = _Orbit(camera, scene, looks, center, float(low[2]), distance, focal, half_image, device, key)
    info = SessionInfo(
        name=name,
        views=camera.recorded_views,
        category=None if from_file else what,
        instance=None if from_file else str(instance),
        source="virtual",
        sensor=", ".join([model, *looks.words, f"rays cast by {scene.raycaster.name}"]),
        capture="circle",
        outline_known=True,
        elevation_deg=camera.elevation_deg,
        views_per_turn=camera.views / camera.every,
    )
    return Session(info, tuple(_name(i) for i in range(camera.recorded_views)), orbit.view, orbit.truth)


@dataclass(frozen=True, eq=False)
class _Orbit:
    """A depth camera on its circle around a mesh."""

    camera: Camera
    scene: Scene
    looks: Appearance
    center: np.ndarray  # where the camera looks [m]
    table: float  # height of what the object stands on [m]
    distance: float  # from the centre to the camera [m]
    focal: float  # [pixels]
    half_image: int  # [pixels], of the bounding sphere's
    sensor: DepthSensor
    key: tuple[int, ...]  # of everything random

    def truth(self) -> Mapping[int, np.ndarray]:
        """The true pose T_object_camera (4, 4) of every view."""
        return {i: self.pose(i) for i in range(self.camera.recorded_views)}

    def pose(self, index: int) -> np.ndarray:
        """The pose T_object_camera (4, 4) of a view: z points to the object's centre, x is level."""
        azimuth = math.radians(self.camera.start_deg + 360 * index / (self.camera.views / self.camera.every))
        elevation = math.radians(self.camera.elevation_deg)
        level = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        outward = math.cos(elevation) * level + (0, 0, math.sin(elevation))
        right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
        R = np.column_stack([right, np.cross(right, outward), -outward])
        return poses.make(R, self.center + self.distance * outward)

    def view(self, index: int) -> View:
        """What the camera sees from its place on the circle."""
        T_object_camera = self.pose(index)
        rng = np.random.default_rng([self.key[0], index * self.camera.every, *self.key[1:]])
        columns, rows = self._pixels(T_object_camera)
        x, y = np.meshgrid(columns, rows)
        shape = x.shape
        if (shift := self.sensor.shift(shape, rng)) is None:
            directions = self._directions(T_object_camera, x, y)
        else:
            directions = self._directions(T_object_camera, x + shift[0] / self.focal, y + shift[1] / self.focal)
        hits = self.scene.cast(T_object_camera[:3, 3], directions)
        facing = (toward(directions) * hits.normals).sum(axis=1)
        depth = self.sensor.measure(hits.distance.reshape(shape), np.abs(facing).reshape(shape), rng).ravel()
        height = T_object_camera[2, 3] + depth * directions[:, 2] - self.table
        seen = np.isfinite(depth) & (height > self.sensor.table_cut(rng))

        rays = np.column_stack([x.ravel(), y.ravel(), np.ones(x.size)])[seen]
        points = (depth[seen, None] * rays).astype(np.float32)
        if self.camera.color_shift:
            directions = self._directions(T_object_camera, x + self.camera.color_shift / self.focal, y)
            hits = self.scene.cast(T_object_camera[:3, 3], directions)
        colors = self.looks.colors(T_object_camera, directions[seen], hits.of(seen))
        if colors is not None:
            colors = add_noise(colors, self.camera.color_noise, np.random.default_rng([*self.key, index, _COLORS]))
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


def _any_of(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _name(index: int) -> str:
    return f"view_{index:03d}"


def _half_image(radius: float, distance: float, focal: float) -> int:
    """Half the side [pixels] of the image that holds the object's bounding sphere; 240 at most by default.

    Raises InvalidOption where the camera would stand in that sphere, or the image would be too large.
    """
    if distance <= radius:
        problem = f"the camera would stand inside the object, which reaches {radius:.3g} m from its centre"
        raise InvalidOption(setting("distance", distance), problem, "give more, or leave it out")
    half = math.ceil(focal * radius / math.sqrt(distance**2 - radius**2))
    if (pixels := (2 * half) ** 2) > MAX_PIXELS:
        problem = f"the object would fill an image of {pixels / 1e6:.0f} megapixels (at most {MAX_PIXELS / 1e6:.0f})"
        remedy = Wording("give a shorter {focal} or a longer {distance}")
        raise InvalidOption(setting("focal", focal), problem, remedy)
    return half
