"""The parametric objects, each built once, and what a mesh is asked without knowing how it was put together."""

from functools import cache
from types import ModuleType

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation import objects


@cache
def built(name: str, instance: int = 1) -> Mesh:
    """The object's instance."""
    return objects.build(name, instance)


def instances(name: str, count: int | None = None) -> list[Mesh]:
    """The first instances of an object: unless told, as many as show every style it comes in."""
    count = count or (12 if name in objects.CATEGORIES else 4)
    return [built(name, instance) for instance in range(1, count + 1)]


def of_style(module: ModuleType, style, count: int = 3) -> list[Mesh]:
    """The first instances of a category's style."""
    first, step = module.STYLES.index(style) + 1, len(module.STYLES)
    return [built(module.__name__.rpartition(".")[2], first + step * turn) for turn in range(count)]


def extents(meshes: list[Mesh]) -> np.ndarray:
    """The sides (N, 3) of the meshes' bounding boxes [m]."""
    return np.array([np.ptp(mesh.vertices, axis=0) for mesh in meshes])


def assert_closed_and_outward(mesh: Mesh) -> None:
    """Every edge is of two triangles that run along it in opposite directions, and every part has a positive volume."""
    start, end = mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).T
    count = len(mesh.vertices)
    ahead, back = np.sort(start * count + end), np.sort(end * count + start)
    assert (np.diff(ahead) > 0).all()
    np.testing.assert_array_equal(ahead, back)
    part = part_of(mesh)
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] - mesh.vertices.mean(axis=0) for i in range(3))
    volumes = np.bincount(part[mesh.triangles[:, 0]], np.einsum("ti,ti->t", a, np.cross(b, c)) / 6, part.max() + 1)
    assert (volumes > 0).all()


def part_of(mesh: Mesh) -> np.ndarray:
    """The number (V,) of the connected part that each vertex belongs to."""
    start, end = mesh.triangles[:, [0, 1, 1, 2]].reshape(-1, 2).T
    shape = len(mesh.vertices), len(mesh.vertices)
    return connected_components(coo_array((np.ones(len(start)), (start, end)), shape))[1]


def largest_part(mesh: Mesh) -> np.ndarray:
    """Which vertices (V,) are of the part that has the most: the body, where what is stuck on is small."""
    part = part_of(mesh)
    return part == np.bincount(part).argmax()


def crossings(mesh: Mesh, axis: str, *place: float) -> np.ndarray:
    """Where along `axis`, ascending [m], a line at `place` on the other two axes goes through the surface."""
    along = "xyz".index(axis)
    flat = np.delete(mesh.vertices, along, axis=1) - np.add(place, (1.3e-5, 2.1e-5))  # just beside edges and vertices
    corners = [flat[mesh.triangles[:, i]] for i in range(3)]
    near = (np.minimum.reduce(corners) < 0).all(axis=1) & (np.maximum.reduce(corners) > 0).all(axis=1)
    a, b, c = (corner[near] for corner in corners)
    areas = np.column_stack([np.linalg.det(np.stack(pair, axis=1)) for pair in ((b, c), (c, a), (a, b))])
    hit = (areas > 0).all(axis=1) | (areas < 0).all(axis=1)
    shares = areas[hit] / areas[hit].sum(axis=1, keepdims=True)
    return np.sort((shares * mesh.vertices[mesh.triangles[near][hit], along]).sum(axis=1))


def dents(points: np.ndarray) -> np.ndarray:
    """How far below the convex hull of all each point (N, 3) lies [m]."""
    equations = ConvexHull(points).equations
    return -(points @ equations[:, :3].T + equations[:, 3]).max(axis=1)
