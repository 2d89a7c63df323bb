"""A mesh to cast rays at, and the light that falls on it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from orbitscan.recorder.objects.mesh import Mesh
from orbitscan.recorder.sources.mesh_file import load_open3d

if TYPE_CHECKING:
    from open3d.t.geometry import RaycastingScene

LIGHT = np.array([0.36, -0.48, 0.80])  # the direction to a lamp that stands still beside the object
AMBIENT = 0.6  # share of the light that comes from everywhere


@dataclass(frozen=True, eq=False)
class Hits:
    """Where rays first meet a mesh; the arrays have a row for each ray."""

    distance: np.ndarray  # (N,) float64, in lengths of the ray's direction; inf where there is nothing
    normals: np.ndarray  # (N, 3) of the triangle that was met
    triangles: np.ndarray  # (N,) its index
    uv: np.ndarray  # (N, 2) where on it


@dataclass(frozen=True, eq=False)
class Scene:
    """A mesh; Open3D, which casts the rays, is loaded with the first of them."""

    mesh: Mesh
    threads: int = 0  # that cast the rays; 0: all

    def cast(self, origin: np.ndarray, directions: np.ndarray) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh."""
        origins = np.broadcast_to(origin, directions.shape)
        rays = load_open3d().core.Tensor(np.hstack([origins, directions]).astype(np.float32))
        hits = self._tree.cast_rays(rays, nthreads=self.threads)
        distance, normals, triangles, uv = (
            hits[key].numpy() for key in ("t_hit", "primitive_normals", "primitive_ids", "primitive_uvs")
        )
        return Hits(distance.astype(np.float64), normals, triangles, uv)

    def colors(self, triangles: np.ndarray, uv: np.ndarray, normals: np.ndarray) -> np.ndarray | None:
        """(N, 3) uint8, interpolated between the mesh's vertices and lit; None where the mesh has none."""
        if self.mesh.colors is None:
            return None
        corners = self.mesh.colors[self.mesh.triangles[triangles]]  # (N, 3, 3)
        weights = np.column_stack([1 - uv.sum(axis=1), uv])
        light = AMBIENT + (1 - AMBIENT) * np.clip((normals * LIGHT).sum(axis=1), 0, 1)
        colors = (weights[:, :, None] * corners).sum(axis=1) * light[:, None]
        return np.clip(np.rint(colors), 0, 255).astype(np.uint8)

    @cached_property
    def _tree(self) -> RaycastingScene:
        o3d = load_open3d()
        tree = o3d.t.geometry.RaycastingScene()
        vertices, triangles = self.mesh.vertices.astype(np.float32), self.mesh.triangles.astype(np.uint32)
        tree.add_triangles(o3d.core.Tensor(vertices), o3d.core.Tensor(triangles))
        return tree
