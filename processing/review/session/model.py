"""The model in the recording: its points, the outliers taken from it, and its surface."""

import numpy as np
import rerun as rr

from orbitscan.processing.results.records import Model
from orbitscan.processing.review import entities


def log_model(stream: rr.RecordingStream, model: Model, up: np.ndarray) -> None:
    """Writes a model; without colours it is shaded by height along `up` (3,)."""
    colors = model.colors if model.colors is not None else entities.height_colors(model.points, up)
    stream.log("/model/points", rr.Points3D(model.points, colors=colors, radii=-1.5), static=True)
    outliers = rr.Points3D(model.removed, colors=entities.BAD_COLOR, radii=-2.0)
    stream.log("/model/outliers", outliers, static=True)
    if (mesh := model.mesh) is not None:
        colors = mesh.colors if mesh.colors is not None else entities.height_colors(mesh.vertices, up)
        surface = rr.Mesh3D(
            vertex_positions=mesh.vertices,
            triangle_indices=mesh.triangles,
            vertex_colors=colors,
            vertex_normals=_vertex_normals(mesh.vertices, mesh.triangles),
        )
        stream.log("/model/mesh", surface, static=True)


def _vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(V, 3) unit: the mean of the triangles around each vertex, by area; without them the viewer shades nothing."""
    a, b, c = vertices[triangles].astype(np.float64).swapaxes(0, 1)
    across = np.cross(b - a, c - a)
    normals = np.zeros(vertices.shape)
    for corner in range(3):
        np.add.at(normals, triangles[:, corner], across)
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
