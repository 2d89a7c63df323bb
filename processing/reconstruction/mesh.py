"""A surface through the model's points (Kazhdan, Screened Poisson surface reconstruction, 2013; Open3D's)."""

from dataclasses import dataclass

import numpy as np
from numba import get_num_threads
from scipy.spatial import cKDTree

from orbitscan.processing.surface.normals import estimate_normals
from orbitscan.recorder.libraries import load_open3d
from orbitscan.recorder.mesh import Mesh

_MARGIN = 1.2  # times the extent: the octree's cube
_DEPTHS = 5, 10  # least and most levels of the octree: a deeper one takes gigabytes


@dataclass(frozen=True)
class MeshSettings:
    """Lengths are multiples of the model's resolution; not in the thesis, which ends with points."""

    wanted: bool = False
    normal_radius: float = 4.0
    max_gap: float = 3.0  # the surface is cut where it is farther from every point: nothing was seen there


def reconstruct_mesh(
    points: np.ndarray, towards: np.ndarray, colors: np.ndarray | None, resolution: float, settings: MeshSettings
) -> Mesh | None:
    """Reconstruct the surface through points (N, 3), seen from the directions `towards` (N, 3), with colours (N, 3).

    The resolution [m] is the points'. None where they lie so far apart that no normal can be told.

    Raises MissingLibrary where Open3D cannot be loaded.
    """
    o3d = load_open3d("do without a mesh")
    normals = estimate_normals(points, settings.normal_radius * resolution, None)
    normals[np.einsum("ni,ni->n", normals, towards) < 0] *= -1
    known = np.isfinite(normals[:, 0])
    if not known.any():
        return None
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points[known].astype(np.float64)))
    cloud.normals = o3d.utility.Vector3dVector(normals[known])
    extent = float(np.ptp(points, axis=0).max())
    depth = int(np.clip(np.ceil(np.log2(_MARGIN * extent / resolution)), *_DEPTHS))
    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        surface, _ = o3d.geometry.TriangleMesh.create_from_point_cloud_poisson(cloud, depth=depth, n_threads=1)
    vertices, triangles = np.asarray(surface.vertices), np.asarray(surface.triangles).astype(np.int64)
    gap, nearest = cKDTree(points).query(vertices, workers=get_num_threads())
    triangles = triangles[(gap <= settings.max_gap * resolution)[triangles].all(axis=1)]
    used, renumbered = np.unique(triangles, return_inverse=True)
    painted = None if colors is None else colors[nearest[used]]
    return Mesh(vertices[used], renumbered.reshape(-1, 3), painted)
