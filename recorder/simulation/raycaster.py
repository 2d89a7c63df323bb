"""Where rays meet triangles: what a raycaster answers, and Open3D's."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

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


class Raycaster(Protocol):
    """What finds where rays meet the triangles of a mesh."""

    name: str  # as recordings tell it

    def cast(self, origin: np.ndarray, directions: np.ndarray, threads: int) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh; `threads` 0: all."""


class Open3DRaycaster:
    """Embree, as Open3D has it: single precision."""

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
        distance, normals, triangles, uv = (
            hits[key].numpy() for key in ("t_hit", "primitive_normals", "primitive_ids", "primitive_uvs")
        )
        return Hits(distance.astype(np.float64), normals, triangles, uv)
