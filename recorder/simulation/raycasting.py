"""A mesh as rays meet it: where, on which triangle, in which colour."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orbitscan.recorder.exceptions import MissingLibrary
from orbitscan.recorder.libraries import load_open3d
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.raycaster import Hits, Open3DRaycaster, Raycaster

LIGHT = np.array([0.36, -0.48, 0.80])  # the direction to a lamp that stands still beside the object
AMBIENT = 0.6  # share of the light that comes from everywhere


@dataclass(frozen=True, eq=False)
class Scene:
    """A mesh; what casts the rays is loaded with the first of them."""

    mesh: Mesh
    threads: int = 0  # that cast the rays; 0: all

    def cast(self, origin: np.ndarray, directions: np.ndarray) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh."""
        return self.raycaster.cast(origin, directions, self.threads)

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
    def raycaster(self) -> Raycaster:
        """Open3D's (Embree); ours where that does not load."""
        try:
            return Open3DRaycaster(self.mesh, load_open3d("do without"))
        except MissingLibrary:
            from orbitscan.recorder.simulation.box_tree import BoxTree  # numba, which takes half a second

            return BoxTree(self.mesh)
