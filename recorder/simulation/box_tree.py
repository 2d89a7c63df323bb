"""A raycaster of our own, for machines where Open3D does not load: triangles in a tree of boxes, double precision.

Boxes are halved at the median of their triangles' centres; a ray visits the nearer half first. A triangle is met as in
Möller, Trumbore: Fast, Minimum Storage Ray/Triangle Intersection (1997).
"""

import logging
from typing import NamedTuple

import numpy as np

from orbitscan.recorder.kernels import is_kept, kernel, over_slices
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.raycasting import Hits

_LEAF = 4  # triangles of a smallest box, at least
_DEPTH = 64  # boxes that wait while a ray goes through another: more than the tree has levels
_EDGE = 1e-9  # how far outside, as a share of its sides, a triangle still is met: no ray passes between two
_HUGE = 1e300  # the reciprocal of nothing: with infinity, a ray that runs along a box's side would be nowhere


class _Tree(NamedTuple):
    """Boxes within boxes: the halves of box i are 2 i + 1 and 2 i + 2; the last L are leaves."""

    boxes: np.ndarray  # (2 L - 1, 6) their lowest and highest corners, the root first
    starts: np.ndarray  # (L + 1,) where each leaf starts among the triangles
    order: np.ndarray  # (T,) the triangles' indices
    first: np.ndarray  # (T, 3) a corner
    sides: np.ndarray  # (T, 2, 3) the sides from there


class _Met(NamedTuple):
    """What rays meet first, filled in by the kernel."""

    distance: np.ndarray  # (N,)
    triangles: np.ndarray  # (N,)
    uv: np.ndarray  # (N, 2)


class BoxTree:
    """A mesh's triangles in boxes within boxes. Rays and corners are rounded as Open3D's are, so that both agree."""

    name = "orbitscan"

    def __init__(self, mesh: Mesh) -> None:
        if not is_kept(_follow):
            logging.getLogger(__name__).warning("Compiling the raycaster: once on this machine, about 3 s ...")
        corners = mesh.vertices.astype(np.float32).astype(np.float64)[mesh.triangles]  # (T, 3, 3)
        low, high = corners.min(axis=1), corners.max(axis=1)
        order, starts = _halve((low + high) / 2)
        boxes = _enclose(low[order], high[order], starts)
        sides = corners[order, 1:] - corners[order, :1]
        self._tree = _Tree(boxes, starts, order, corners[order, 0], sides)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        self._normals = normals / np.where(lengths > 0, lengths, 1)

    def cast(self, origin: np.ndarray, directions: np.ndarray, threads: int) -> Hits:
        """Where rays from one origin (3,) in the directions (N, 3) first meet the mesh; `threads` 0: all."""
        origin, rays = (array.astype(np.float32).astype(np.float64) for array in (origin, directions))
        count = len(rays)
        met = _Met(np.full(count, np.inf), np.zeros(count, np.int64), np.zeros((count, 2)))
        over_slices(_follow, count, self._tree, origin, rays, met, threads=threads)
        normals = np.where(np.isfinite(met.distance)[:, None], self._normals[met.triangles], 0)
        return Hits(met.distance, normals, met.triangles, met.uv)


def _halve(centers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The triangles' order (T,) in the leaves, and where each leaf starts in it (L + 1,); L is a power of two.

    Level by level, each part of the order is sorted along the longest axis of its centres (T, 3), which halves it.
    """
    count = len(centers)
    leaves = 1 << max(0, (count // _LEAF).bit_length() - 1)
    starts = np.arange(leaves + 1) * count // leaves
    order = np.arange(count)
    for level in range(leaves.bit_length() - 1):
        bounds = starts[:: leaves >> level]
        part = np.repeat(np.arange(len(bounds) - 1), np.diff(bounds))
        placed = centers[order]
        extents = np.maximum.reduceat(placed, bounds[:-1]) - np.minimum.reduceat(placed, bounds[:-1])
        along = placed[np.arange(count), extents.argmax(axis=1)[part]]
        order = order[np.lexsort((along, part))]
    return order, starts


def _enclose(low: np.ndarray, high: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """The boxes (2 L - 1, 6) of all levels, the root first: the halves of box i are 2 i + 1 and 2 i + 2."""
    levels = [np.hstack([np.minimum.reduceat(low, starts[:-1]), np.maximum.reduceat(high, starts[:-1])])]
    while len(levels[0]) > 1:
        left, right = levels[0][::2], levels[0][1::2]
        levels.insert(0, np.hstack([np.minimum(left[:, :3], right[:, :3]), np.maximum(left[:, 3:], right[:, 3:])]))
    return np.concatenate(levels)


@kernel
def _follow(start, stop, tree, origin, rays, met):  # noqa: ANN001, ANN202
    """Fill in the distance, triangle and place on it of the rays from `start` to `stop` that meet one."""
    waiting = np.empty(_DEPTH, np.int64)
    leaves = len(tree.starts) - 1
    for r in range(start, stop):
        x, y, z = rays[r]
        inverse = (1 / x if x != 0 else _HUGE, 1 / y if y != 0 else _HUGE, 1 / z if z != 0 else _HUGE)
        waiting[0] = 0
        count = 1
        while count > 0:
            count -= 1
            box = waiting[count]
            if _enter(tree.boxes[box], origin, inverse) >= met.distance[r]:
                continue
            if box >= leaves - 1:
                leaf = box - (leaves - 1)
                for i in range(tree.starts[leaf], tree.starts[leaf + 1]):
                    t, u, v = _meet(tree.first[i], tree.sides[i, 0], tree.sides[i, 1], origin, x, y, z)
                    if 0 < t < met.distance[r]:
                        met.distance[r], met.triangles[r] = t, tree.order[i]
                        met.uv[r, 0], met.uv[r, 1] = u, v
                continue
            left, right = 2 * box + 1, 2 * box + 2
            if _enter(tree.boxes[left], origin, inverse) < _enter(tree.boxes[right], origin, inverse):
                left, right = right, left
            waiting[count], waiting[count + 1] = left, right  # the nearer one is taken first
            count += 2


@kernel
def _enter(box, origin, inverse):  # noqa: ANN001, ANN202
    """Where a ray, by the reciprocals of its direction, enters a box; inf where it does not."""
    enter, leave = 0.0, np.inf
    for axis in range(3):
        a, b = (box[axis] - origin[axis]) * inverse[axis], (box[3 + axis] - origin[axis]) * inverse[axis]
        enter, leave = max(enter, min(a, b)), min(leave, max(a, b))
    return enter if enter <= leave else np.inf


@kernel
def _meet(first, p, q, origin, x, y, z):  # noqa: ANN001, ANN202
    """Where a ray in the direction x, y, z meets a triangle (inf: it does not), and u, v on its sides p and q."""
    a, b, c = y * q[2] - z * q[1], z * q[0] - x * q[2], x * q[1] - y * q[0]  # direction x q
    volume = p[0] * a + p[1] * b + p[2] * c
    if volume == 0:
        return np.inf, 0.0, 0.0
    s0, s1, s2 = origin[0] - first[0], origin[1] - first[1], origin[2] - first[2]
    u = (s0 * a + s1 * b + s2 * c) / volume
    d, e, f = s1 * p[2] - s2 * p[1], s2 * p[0] - s0 * p[2], s0 * p[1] - s1 * p[0]  # s x p
    v = (x * d + y * e + z * f) / volume
    if u < -_EDGE or v < -_EDGE or u + v > 1 + _EDGE:
        return np.inf, 0.0, 0.0
    return (q[0] * d + q[1] * e + q[2] * f) / volume, u, v
