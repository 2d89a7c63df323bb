"""An object's true surface: what of it a camera sees, with true normals, and how densely."""

from functools import lru_cache

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.sensors import KEPT_INCIDENCE_DEG, LOST_INCIDENCE_DEG

CREASE_DEG = 25.0  # facets that meet at less stand for a round surface
SAME = 2e-4  # of the distance: two hits on one ray are one point


class Scene:
    """A mesh to cast rays at; Open3D, which does that, is loaded with the first one."""

    def __init__(self, mesh: Mesh) -> None:
        import open3d

        self._tensor = open3d.core.Tensor
        self.diameter = float(np.linalg.norm(np.subtract(*mesh.bounds)))
        self._corner_normals = smooth_normals(mesh.vertices, mesh.triangles)
        self._rays = open3d.t.geometry.RaycastingScene()
        vertices, triangles = mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)
        self._rays.add_triangles(self._tensor(vertices), self._tensor(triangles))

    def surface(self, eye: np.ndarray, through: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where rays from an eye (3,) through points (N, 3) first meet the surface, NaN where they do not, and its unit
        normals there, towards the eye: those of the round surface and those of its facets; each (N, 3)."""
        directions = through - eye
        hits = self._cast(eye, directions)
        reach = hits["t_hit"].numpy().astype(np.float64)
        reach[~np.isfinite(reach)] = np.nan
        uv = hits["primitive_uvs"].numpy()
        triangle = np.where(np.isfinite(reach), hits["primitive_ids"].numpy().astype(np.int64), 0)
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        normals = (weights[:, :, None] * self._corner_normals[triangle]).sum(axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        facets = hits["primitive_normals"].numpy().astype(np.float64)
        towards = -np.sign((facets * directions).sum(axis=1, keepdims=True))
        return eye + reach[:, None] * directions, towards * normals, towards * facets

    def visible(self, eye: np.ndarray, points: np.ndarray) -> np.ndarray:
        """(N,) bool: whether nothing stands between an eye and points of the surface."""
        return self._cast(eye, points - eye)["t_hit"].numpy() > 1 - SAME

    def _cast(self, eye: np.ndarray, directions: np.ndarray) -> dict:
        rays = np.hstack([np.broadcast_to(eye, directions.shape), directions]).astype(np.float32)
        return self._rays.cast_rays(self._tensor(rays))


@lru_cache(maxsize=4)
def of_object(name: str, instance: int) -> Scene:
    """The scene of one of `orbitscan.recorder.simulation.objects`."""
    return Scene(objects.build(name, instance))


def density(points: np.ndarray, normals: np.ndarray, focal: float) -> np.ndarray:
    """(N,) points that a virtual camera measures per square metre of surface [1/m^2], at points in its frame.

    A pixel is 1/f wide at depth 1. A surface at the distance r and depth z, turned by theta from the ray, shows
    cos(theta) / r^2 of solid angle per area, which is cos(theta) (r / z) / z^2 of the image at depth 1. Depth cameras
    lose surfaces that turn away: see `KEPT_INCIDENCE_DEG` of the virtual camera.
    """
    distance, z = np.linalg.norm(points, axis=1), points[:, 2]
    cosine = np.clip(-(points * normals).sum(axis=1) / distance, 0, 1)
    kept = (LOST_INCIDENCE_DEG - np.degrees(np.arccos(cosine))) / (LOST_INCIDENCE_DEG - KEPT_INCIDENCE_DEG)
    return focal**2 * cosine * distance / z**3 * np.clip(kept, 0, 1)


def smooth_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(M, 3, 3) a normal for each corner of each triangle: the mean over the triangles that meet there with no crease.

    Interpolated, they are the normals of the round surface that the facets stand for; facets would make believe that a
    bowl's turn can be seen.
    """
    edges = vertices[triangles[:, 1:]] - vertices[triangles[:, :1]]
    weighted = np.cross(edges[:, 0], edges[:, 1])  # as long as twice the triangle's area
    length = np.linalg.norm(weighted, axis=1, keepdims=True)
    unit = weighted / np.where(length > 0, length, 1)
    _, places = np.unique(np.round(vertices * 1e7).astype(np.int64), axis=0, return_inverse=True)
    place = places.ravel()[triangles].ravel()  # of every corner; corners in one place may be several vertices
    order = np.argsort(place, kind="stable")
    count = np.bincount(place)
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    corner = np.repeat(np.arange(len(place)), count[place])  # every corner beside every corner in its place
    start = np.repeat(np.cumsum(count[place]) - count[place], count[place])
    other = order[np.repeat(first[place], count[place]) + np.arange(len(corner)) - start]
    round_ = (unit[corner // 3] * unit[other // 3]).sum(axis=1) > np.cos(np.radians(CREASE_DEG))
    normals = np.zeros((len(place), 3))
    np.add.at(normals, corner[round_], weighted[other[round_] // 3])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return (normals / np.where(lengths > 0, lengths, 1)).reshape(-1, 3, 3)
