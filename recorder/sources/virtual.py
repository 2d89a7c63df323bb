"""A virtual depth camera that circles a mesh: exact poses, a known noise model, any number of points."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from recorder import objects, poses
from recorder.exceptions import InvalidOption, MissingLibrary, UnreadableCloud
from recorder.objects.mesh import Mesh
from recorder.session import DEFAULT_VIEWS, Session, SessionInfo, View

if TYPE_CHECKING:
    from open3d.t.geometry import RaycastingScene

# Depth cameras lose a surface as it turns away from them; none is measured beyond about 80 degrees (Nguyen, Izadi,
# Lovell: Modeling Kinect Sensor Noise for Improved 3D Reconstruction and Tracking, 3DIMPVT 2012). Up to the first
# angle every point is kept, at the second none, linearly between.
KEPT_INCIDENCE_DEG, LOST_INCIDENCE_DEG = 65.0, 80.0
MAX_DIAMETER = 20.0  # [m]; a mesh beyond it is in millimetres
MAX_PIXELS = 8_000_000  # of an image; more would not fit small machines' memory
LIGHT = np.array([0.36, -0.48, 0.80])  # the direction to a lamp that stands still beside the object
AMBIENT = 0.6  # share of the light that comes from everywhere


def simulate(
    what: str,
    *,
    instance: int = 1,
    views: int = DEFAULT_VIEWS,
    elevation_deg: float = 30.0,
    distance: float | None = None,
    focal: float = 525.0,
    noise_mm: float = 1.0,
    seed: int = 0,
) -> Session:
    """One turn of a depth camera around an object of `recorder.objects` or a mesh file (STL, OBJ, PLY; metres, z up).

    The camera looks at the centre of the object's bounding box from `distance` [m] (None: max(1 m, 2.5 object radii)),
    first from the front, +x, then in equal steps counterclockwise about z seen from above. `focal` is in pixels; the
    depth z has Gaussian noise of sigma = noise_mm (z / 1 m)^2. Views are rendered when loaded, each from the seed and
    its index alone. Raises InvalidOption, and UnreadableCloud for a file that holds no mesh.
    """
    path = Path(what)
    from_file = what not in objects.names() and bool(path.suffix or path.exists())
    mesh = _read_mesh(path) if from_file else objects.build(what, instance)
    low, high = mesh.bounds
    center = (low + high) / 2
    radius = float(np.linalg.norm(mesh.vertices - center, axis=1).max())
    distance = max(1.0, 2.5 * radius) if distance is None else distance
    _check_options(radius, views, elevation_deg, distance, focal, noise_mm, seed)
    orbit = _Orbit(
        mesh=mesh,
        center=center,
        distance=distance,
        elevation_deg=elevation_deg,
        views=views,
        focal=focal,
        half_image=_half_image(radius, distance, focal),
        noise=noise_mm / 1000,
        seed=seed,
    )
    info = SessionInfo(
        name=path.stem if from_file else what if instance == 1 else f"{what}_{instance}",
        views=views,
        category=None if from_file else what,
        instance=None if from_file else str(instance),
        source="virtual",
        sensor="virtual depth camera",
        capture="circle",
        elevation_deg=elevation_deg,
        views_per_turn=views,
    )
    return Session(info, tuple(_name(i) for i in range(views)), orbit.view, orbit.truth)


@dataclass(frozen=True, eq=False)
class _Orbit:
    """A depth camera on its circle around a mesh."""

    mesh: Mesh
    center: np.ndarray  # where the camera looks [m]
    distance: float  # from the centre to the camera [m]
    elevation_deg: float
    views: int
    focal: float  # [pixels]
    half_image: int  # [pixels]
    noise: float  # standard deviation of the depth at 1 m [m]
    seed: int
    start_deg: float = 0.0  # azimuth of view 0, from the front

    def truth(self) -> Mapping[int, np.ndarray]:
        """T_object_camera of every view."""
        return {i: self.pose(i) for i in range(self.views)}

    def pose(self, index: int) -> np.ndarray:
        """T_object_camera: z towards the object's centre, x level."""
        azimuth = math.radians(self.start_deg + 360 * index / self.views)
        elevation = math.radians(self.elevation_deg)
        level = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        outward = math.cos(elevation) * level + (0, 0, math.sin(elevation))
        right = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
        return poses.make(
            np.column_stack([right, np.cross(right, outward), -outward]), self.center + self.distance * outward
        )

    def view(self, index: int) -> View:
        """What the camera sees from its place on the circle."""
        o3d = _open3d()
        T_object_camera = self.pose(index)
        pixels = (np.arange(-self.half_image, self.half_image) + 0.5) / self.focal
        x, y = (grid.ravel() for grid in np.meshgrid(pixels, pixels))
        rays = np.column_stack([x, y, np.ones_like(x)])  # of depth 1, so that a hit's distance is its depth
        directions = poses.transform(poses.make(T_object_camera[:3, :3], np.zeros(3)), rays)
        origins = np.broadcast_to(T_object_camera[:3, 3], directions.shape)
        hits = self._scene.cast_rays(o3d.core.Tensor(np.hstack([origins, directions]).astype(np.float32)))
        depth = hits["t_hit"].numpy().astype(np.float64)

        # A draw for every ray, hit or not: a point's noise depends on nothing but its pixel.
        generator = np.random.default_rng([self.seed, index])
        luck, error = generator.random(len(rays)), generator.standard_normal(len(rays))
        toward = -directions / np.linalg.norm(directions, axis=1, keepdims=True)
        normals = hits["primitive_normals"].numpy()
        facing = (toward * normals).sum(axis=1)
        seen = np.isfinite(depth) & (luck < _chance(np.abs(facing)))

        depth = depth[seen] + self.noise * depth[seen] ** 2 * error[seen]
        normals = normals[seen] * np.sign(facing[seen, None])
        colors = self._colors(hits["primitive_ids"].numpy()[seen], hits["primitive_uvs"].numpy()[seen], normals)
        return View(index, _name(index), (index + 1) * 10**9, (depth[:, None] * rays[seen]).astype(np.float32), colors)

    def _colors(self, triangle: np.ndarray, uv: np.ndarray, normals: np.ndarray) -> np.ndarray | None:
        """(N, 3) uint8, interpolated between the mesh's vertices and lit; None where the mesh has none."""
        if self.mesh.colors is None:
            return None
        corners = self.mesh.colors[self.mesh.triangles[triangle]]  # (N, 3, 3)
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        light = AMBIENT + (1 - AMBIENT) * np.clip((normals * LIGHT).sum(axis=1), 0, 1)
        colors = (weights[:, :, None] * corners).sum(axis=1) * light[:, None]
        return np.clip(np.rint(colors), 0, 255).astype(np.uint8)

    @cached_property
    def _scene(self) -> RaycastingScene:
        o3d = _open3d()
        scene = o3d.t.geometry.RaycastingScene()
        vertices, triangles = self.mesh.vertices.astype(np.float32), self.mesh.triangles.astype(np.uint32)
        scene.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(triangles))
        return scene


def _open3d() -> ModuleType:
    """Open3D, imported late: it takes a second, and system libraries that a bare machine may lack."""
    try:
        import open3d
    except (ImportError, OSError) as error:
        problem = f"cannot be loaded ({str(error).splitlines()[0]})"
        raise MissingLibrary(
            "open3d", problem, "install what is missing (Debian: libusb-1.0-0 libgl1 libgomp1)"
        ) from None
    return open3d


def _name(index: int) -> str:
    return f"view_{index:03d}"


def _chance(cosine: np.ndarray) -> np.ndarray:
    """The probability that a point is measured, by the cosine between its normal and the direction to the camera."""
    incidence_deg = np.degrees(np.arccos(np.clip(cosine, 0, 1)))
    return (LOST_INCIDENCE_DEG - incidence_deg) / (LOST_INCIDENCE_DEG - KEPT_INCIDENCE_DEG)


def _half_image(radius: float, distance: float, focal: float) -> int:
    """Half the side [pixels] of the image that holds the object's bounding sphere; 240 at most by default."""
    return math.ceil(focal * radius / math.sqrt(distance**2 - radius**2))


def _check_options(
    radius: float, views: int, elevation_deg: float, distance: float, focal: float, noise_mm: float, seed: int
) -> None:
    """Raise InvalidOption for the first value that makes no sense for an object of the radius."""
    if views < 1:
        raise InvalidOption(f"--views {views}", "a turn has at least one view", "give 1 or more")
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


def _read_mesh(path: Path) -> Mesh:
    """The triangles of a mesh file; raises UnreadableCloud."""
    o3d = _open3d()
    remedy = "name a mesh file (STL, OBJ, PLY, OFF, GLB) or one of " + ", ".join(objects.names())
    if not path.is_file():
        raise UnreadableCloud(path, "is a folder" if path.is_dir() else "no such file", remedy)
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        read = o3d.io.read_triangle_mesh(str(path))
    vertices, triangles = np.asarray(read.vertices), np.asarray(read.triangles).astype(np.int64)
    if not len(triangles):
        raise UnreadableCloud(path, "holds no triangles that can be read", remedy)
    if not np.isfinite(vertices).all():
        raise UnreadableCloud(path, "a vertex is not finite", "export the mesh again")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise UnreadableCloud(path, "a triangle names a vertex that is not there", "export the mesh again")
    diameter = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if not 0 < diameter <= MAX_DIAMETER:
        problem = f"measures {diameter:.4g} m across, as if it were not in metres"
        raise UnreadableCloud(path, problem, "scale it to metres (from millimetres by 0.001)")
    colors = np.rint(np.asarray(read.vertex_colors) * 255).astype(np.uint8) if read.has_vertex_colors() else None
    return Mesh(vertices, triangles, colors)
