"""Mesh files as triangles, and Open3D, which reads them."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np

from orbitscan.recorder import objects
from orbitscan.recorder.exceptions import MissingLibrary, UnreadableCloud
from orbitscan.recorder.objects.mesh import Mesh

MAX_DIAMETER = 20.0  # [m]; a mesh beyond it is in millimetres


def load_open3d() -> ModuleType:
    """Open3D, imported late: it takes a second, and system libraries that a bare machine may lack."""
    try:
        import open3d
    except (ImportError, OSError) as error:
        problem = f"cannot be loaded ({str(error).splitlines()[0]})"
        raise MissingLibrary(
            "open3d", problem, "install what is missing (Debian: libusb-1.0-0 libgl1 libgomp1)"
        ) from None
    return open3d


def read_mesh(path: Path) -> Mesh:
    """The triangles of a mesh file (STL, OBJ, PLY, OFF, GLB; metres); raises UnreadableCloud."""
    o3d = load_open3d()
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
