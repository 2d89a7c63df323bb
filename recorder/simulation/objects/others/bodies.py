"""Bodies that several other things are made of: sections along x, hoops, and surfaces that are not smooth."""

from dataclasses import replace

import numpy as np

from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation.objects.fruit import bumps
from orbitscan.recorder.simulation.objects.solids import circle, loft


def along_x(x: np.ndarray, sections: np.ndarray) -> Mesh:
    """The solid within sections (S, N, 2) of y and z [m] at the places x (S,) [m]."""
    places = np.broadcast_to(np.asarray(x)[:, None, None], (*sections.shape[:2], 1))
    return loft(np.concatenate([places, sections], axis=2))


def tongue(x: np.ndarray, half: np.ndarray, middle: np.ndarray, dish: np.ndarray, thickness: np.ndarray) -> Mesh:
    """A strip of sheet along x (S,): half its width, its middle's height, how far its edges stand up, thickness [m]."""
    share = np.linspace(-1, 1, 13)
    y = half[:, None] * share
    lower = middle[:, None] + dish[:, None] * share**2
    upper = lower + np.broadcast_to(thickness, len(x))[:, None]
    ring = np.stack([np.hstack([y, y[:, ::-1]]), np.hstack([lower, upper[:, ::-1]])], axis=2)
    return along_x(x, ring)


def rectangle(length: float, width: float, count: int = 8) -> np.ndarray:
    """The outline (4 count, 2) of a rectangle, length along x, `count` points a side [m]."""
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1), (1, 1)]) * (length / 2, width / 2)
    places = np.arange(4 * count) / count
    return np.column_stack([np.interp(places, np.arange(5), corners[:, i]) for i in (0, 1)])


def carton(length: float, width: float, height: float, bulge: float = 0.0) -> Mesh:
    """A box on z = 0 whose upright sides swell by `bulge` in their middle [m]."""
    outline = rectangle(length, width)
    share = outline / (length / 2, width / 2)
    levels = np.linspace(0, 1, 8)
    swell = bulge * np.sin(np.pi * levels)[:, None, None]
    rings = outline + swell * share * (1 - share[:, ::-1] ** 2)
    heights = np.broadcast_to(height * levels[:, None, None], (*rings.shape[:2], 1))
    return loft(np.concatenate([rings, heights], axis=2))


def domed(half: float, height: float, squareness: float, segments: int = 32, flat: float = 0.25) -> np.ndarray:
    """The outline (N, 2) of a section that stands on z = 0: a superellipse, `flat` of its height cut off below [m]."""
    unit = circle(1, segments)
    unit = np.sign(unit) * np.abs(unit) ** (2 / squareness)
    z = np.maximum(unit[:, 1], 2 * flat - 1)
    return np.column_stack([half * unit[:, 0], height * (z + 1 - 2 * flat) / (2 - 2 * flat)])


def hoop(outline: np.ndarray, x: float, y: float, segments: int = 40) -> Mesh:
    """An outline (N, 2) led round the z axis on an ellipse of the half axes x and y [m]; its first axis is outward."""
    angles = 2 * np.pi * np.arange(segments + 1) / segments
    unit = np.column_stack([np.cos(angles), np.sin(angles)])
    outward = unit * (y, x)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    level = (unit * (x, y))[:, None] + outline[:, 0, None] * outward[:, None]
    height = np.broadcast_to(outline[:, 1, None], (*level.shape[:2], 1))
    return loft(np.concatenate([level, height], axis=2))


def rumpled(rng: np.random.Generator, mesh: Mesh, amplitude: float, waves: float = 2.0) -> Mesh:
    """The mesh, its vertices moved by smooth random fields: `amplitude` [m], more `waves` are finer."""
    low, high = mesh.bounds
    places = waves * (mesh.vertices - (low + high) / 2) / np.max(high - low) * 2
    shift = np.stack([bumps(rng, places, amplitude) for _ in range(3)], axis=1)
    return replace(mesh, vertices=mesh.vertices + shift)


def lying(mesh: Mesh) -> Mesh:
    """What was built along z, laid down along x."""
    return mesh.turned("y", 90)
