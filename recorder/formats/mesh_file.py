"""Mesh files as triangles."""

from pathlib import Path

import numpy as np

from orbitscan.recorder.exceptions import UnreadableCloud
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation import objects

MAX_DIAMETER = 20.0  # [m]; a mesh beyond it is in millimetres


def read_mesh(path: Path) -> Mesh:
    """The triangles of a mesh file (STL, OBJ, PLY, OFF, GLB; metres), all its parts; raises UnreadableCloud."""
    remedy = "name a mesh file (STL, OBJ, PLY, OFF, GLB) or one of " + ", ".join(objects.names())
    if not path.is_file():
        raise UnreadableCloud(path, "is a folder" if path.is_dir() else "no such file", remedy)
    vertices, triangles, colors = _load(path)
    if not len(triangles):
        raise UnreadableCloud(path, "holds no triangles that can be read", remedy)
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        raise UnreadableCloud(path, "a triangle names a vertex that is not there", "export the mesh again")
    if not np.isfinite(vertices).all():
        raise UnreadableCloud(path, "a vertex is not finite", "export the mesh again")
    diameter = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if not 0 < diameter <= MAX_DIAMETER:
        problem = f"measures {diameter:.4g} m across, as if it were not in metres"
        raise UnreadableCloud(path, problem, "scale it to metres (from millimetres by 0.001)")
    return Mesh(vertices, triangles, colors)


def _load(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Vertices (V, 3), triangles (T, 3) and colours (V, 3) uint8 of all parts; no triangles where there is no mesh."""
    import trimesh  # takes a quarter of a second

    try:
        parts = [part for part in trimesh.load_scene(path, process=False).dump() if isinstance(part, trimesh.Trimesh)]
    except Exception:  # of a file that is cut, of another kind, or nonsense, its readers raise anything
        parts = []
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    vertices = np.concatenate([np.empty((0, 3)), *(part.vertices for part in parts)])
    triangles = [part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]
    visuals = [part.visual for part in parts]
    painted = [v for v in visuals if isinstance(v, trimesh.visual.ColorVisuals) and v.kind == "vertex"]
    whole = bool(parts) and len(painted) == len(parts)
    colors = np.concatenate([visual.vertex_colors[:, :3] for visual in painted]) if whole else None
    return vertices, np.concatenate([np.empty((0, 3), np.int64), *triangles]), colors
