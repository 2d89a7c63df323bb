"""Closed solids to put objects together from: every one is a loft, a row of rings joined by triangles."""

from collections.abc import Sequence

import numpy as np

from orbitscan.recorder.mesh import Mesh


def loft(sections: np.ndarray | Sequence[np.ndarray]) -> Mesh:
    """The solid within a row of rings (S, N, 3), its two ends closed flat; a ring at either end may be one point.

    The rings may run either way round: the triangles are turned outward.
    """
    stacked = np.asarray(sections, dtype=np.float64)
    ends = stacked[[0, -1]].mean(axis=1)
    rings = stacked[np.ptp(stacked, axis=1).max(axis=1) > 0]
    count, n = rings.shape[:2]
    here = np.arange(n)
    there = np.roll(here, -1)
    first, last = count * n, count * n + 1
    triangles = [np.stack([there, here, np.full(n, first)], axis=1)]
    for low in range(0, (count - 1) * n, n):
        high = low + n
        triangles.append(np.stack([low + here, low + there, high + there], axis=1))
        triangles.append(np.stack([low + here, high + there, high + here], axis=1))
    triangles.append(np.stack([(count - 1) * n + here, (count - 1) * n + there, np.full(n, last)], axis=1))
    mesh = Mesh(np.concatenate([rings.reshape(-1, 3), ends]), np.concatenate(triangles))
    return mesh if mesh.volume > 0 else Mesh(mesh.vertices, mesh.triangles[:, ::-1])


def circle(radius: float, segments: int = 32) -> np.ndarray:
    """A circle's outline (N, 2) [m]."""
    angles = 2 * np.pi * np.arange(segments) / segments
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def rounded_rectangle(length: float, width: float, radius: float, segments: int = 8) -> np.ndarray:
    """The outline (4 (segments + 1), 2) of a rectangle, length along x, with rounded corners [m]."""
    turns = np.linspace(0, np.pi / 2, segments + 1)
    corners = []
    for quarter, (sx, sy) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        angles = turns + quarter * np.pi / 2
        center = np.array([sx * (length / 2 - radius), sy * (width / 2 - radius)])
        corners.append(center + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    return np.concatenate(corners)


def prism(outline: np.ndarray, height: float, bevel: float = 0.0) -> Mesh:
    """An outline (N, 2) about the origin drawn up from z = 0 to the height, its upper and lower edges bevelled [m]."""
    shrunk = outline * (1 - 2 * bevel / np.ptp(outline, axis=0))
    levels = [(shrunk, 0.0), (outline, bevel), (outline, height - bevel), (shrunk, height)]
    if bevel == 0:
        levels = levels[1:3]
    return loft([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in levels])


def box(length: float, width: float, height: float, bevel: float = 0.0) -> Mesh:
    """A box standing on z = 0 about the z axis: length along x, width along y [m]."""
    x, y = length / 2, width / 2
    return prism(np.array([[x, y], [-x, y], [-x, -y], [x, -y]]), height, bevel)


def cylinder(radius: float, height: float, bevel: float = 0.0, segments: int = 32) -> Mesh:
    """A cylinder standing on z = 0 about the z axis [m]."""
    return prism(circle(radius, segments), height, bevel)


def revolve(profile: np.ndarray, segments: int = 48) -> Mesh:
    """A profile (P, 2) of radius and height turned about the z axis [m]."""
    unit = circle(1, segments)
    return loft([np.column_stack([radius * unit, np.full(segments, z)]) for radius, z in profile])


def ellipsoid(x: float, y: float, z: float, segments: int = 24) -> Mesh:
    """An ellipsoid about the origin with the given half axes [m]."""
    latitudes = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    profile = np.column_stack([np.cos(latitudes), np.sin(latitudes)])
    profile[[0, -1], 0] = 0  # cos(pi / 2) is not quite zero
    sphere = revolve(profile, segments)
    return Mesh(sphere.vertices * (x, y, z), sphere.triangles)


def sweep(
    outline: np.ndarray, path: np.ndarray, up: tuple[float, float, float] = (0, 0, 1), scales: np.ndarray | float = 1.0
) -> Mesh:
    """An outline (N, 2) drawn along a path (P, 3) [m], its second axis kept as near to `up` as the path allows.

    It grows by `scales`: one factor, one per point of the path (P, 1) or one per point and axis of the outline (P, 2).
    """
    path = np.asarray(path, dtype=np.float64)
    scales = np.broadcast_to(scales, (len(path), 2))
    tangents = np.gradient(path, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    sections = []
    for point, tangent, scale in zip(path, tangents, scales, strict=True):
        side = np.cross(up, tangent)
        side /= np.linalg.norm(side)
        grown = scale * outline
        sections.append(point + grown[:, :1] * side + grown[:, 1:] * np.cross(tangent, side))
    return loft(sections)
