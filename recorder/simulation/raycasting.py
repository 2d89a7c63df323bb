"""Where rays meet a mesh, and on which triangle: by Open3D, else by a raycaster of our own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from orbitscan.recorder.exceptions import MissingLibrary
from orbitscan.recorder.libraries import load_open3d
from orbitscan.recorder.mesh import Mesh

if TYPE_CHECKING:
    from types import ModuleType


@dataclass(frozen=True, eq=False)
class Hits:
    """Where rays first meet a mesh; the arrays have a row for each ray."""

    distance: np.ndarray  # (N,) float64, in lengths of the ray's direction; inf where there is nothing
    normals: np.ndarray  # (N, 3) of the triangle that was met
    triangles: np.ndarray  # (N,) its index
    uv: np.ndarray  # (N, 2) where on it

    def of(self, rays: np.ndarray) -> Hits:
        """Those of some of the rays."""
        return Hits(self.distance[rays], self.normals[rays], self.triangles[rays], self.uv[rays])


class Raycaster(Protocol):
    """An engine that finds where rays first meet the triangles of a mesh."""

    name: str  # as recordings tell it

    def cast(self, origin: np.ndarray, directions: np.ndarray, threads: int) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh; `threads` 0: all."""


class Open3DRaycaster:
    """Open3D's raycaster (Embree), in single precision."""

    def __init__(self, mesh: Mesh, open3d: ModuleType) -> None:
        self.name = f"Open3D {open3d.__version__}"
        self._tensor = open3d.core.Tensor
        self._scene = open3d.t.geometry.RaycastingScene()
        vertices, triangles = mesh.vertices.astype(np.float32), mesh.triangles.astype(np.uint32)
        self._scene.add_triangles(self._tensor(vertices), self._tensor(triangles))

    def cast(self, origin: np.ndarray, directions: np.ndarray, threads: int) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh; `threads` 0: all."""
        origins = np.broadcast_to(origin, directions.shape)
        rays = self._tensor(np.hstack([origins, directions]).astype(np.float32))
        hits = self._scene.cast_rays(rays, nthreads=threads)
        keys = ("t_hit", "primitive_normals", "primitive_ids", "primitive_uvs")
        distance, normals, triangles, uv = (hits[key].numpy() for key in keys)
        return Hits(distance.astype(np.float64), normals, triangles, uv)


@dataclass(frozen=True, eq=False)
class Scene:
    """A mesh; what casts the rays is loaded with the first of them."""

    mesh: Mesh
    threads: int = 0  # that cast the rays; 0: all

    def cast(self, origin: np.ndarray, directions: np.ndarray) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh."""
        return self.raycaster.cast(origin, directions, self.threads)

    @cached_property
    def raycaster(self) -> Raycaster:
        """What casts the rays: Open3D (Embree), or our own where that does not load."""
        try:
            return Open3DRaycaster(self.mesh, load_open3d("do without"))
        except MissingLibrary:
            from orbitscan.recorder.simulation.box_tree import BoxTree  # numba, which takes half a second

            return BoxTree(self.mesh)
