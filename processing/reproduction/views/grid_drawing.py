"""Voxel grids as they would stand before a viewer beside and above the camera: every voxel a cube, back to front."""

from itertools import product

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Colormap, ListedColormap, LogNorm
from matplotlib.figure import Figure

_AZIMUTH_DEG, _ELEVATION_DEG = -35.0, 22.0  # of the viewer, from the camera's axis
_SHADES = (0.62, 0.9, 0.76)  # of the faces across x, y, z where the value has no colour
_REACH = 0.86  # of a cube of side 1: just beyond its outline
_RIGHT, _TOP = (1, 0, 0), (0, -1, 0)  # in the camera's axes: x right, y down, z forward


def count_colors() -> Colormap:
    """Colours from light for few points to dark for many: the lightness alone tells them apart."""
    return ListedColormap(colormaps["YlGnBu"](np.linspace(0.08, 1, 256)), name="points")


def draw_grid(axes: Axes, grid: np.ndarray, norm: LogNorm | None = None, inches: float = 2.5) -> PolyCollection:
    """Draw a grid (div, div, div) in the camera's axes x, y, z, within its cube; its faces are returned.

    Without `norm` every voxel has one grey. `inches` is about how wide the axes are.
    """
    div = len(grid)
    right, up, toward = _viewer()
    corners, values, across = _visible_faces(grid, toward)
    flat = np.stack([corners @ right, corners @ up], axis=-1) - (div / 2) * np.array([right.sum(), up.sum()])
    line = min(0.3, 0.045 * inches * 72 / (2 * _REACH * div))
    faces = PolyCollection(list(flat), edgecolors="0.25", linewidths=line, rasterized=True, zorder=2)
    if norm is None:
        faces.set_facecolor([(_SHADES[axis],) * 3 for axis in across])
    else:
        faces.set(array=values, cmap=count_colors(), norm=norm)
    lines = [[(line - div / 2) @ right, (line - div / 2) @ up] for line in _far_edges(div, toward)]
    axes.add_collection(LineCollection(list(np.swapaxes(lines, 1, 2)), colors="0.6", linewidths=0.6, zorder=1))
    axes.add_collection(faces)
    reach = (-_REACH * div, _REACH * div)
    axes.set(xlim=reach, ylim=reach, xticks=[], yticks=[], aspect="equal")
    axes.set_axis_off()
    return faces


def draw_count_bar(figure: Figure, axes: Axes | np.ndarray, faces: PolyCollection) -> None:
    """Place a scale beside the axes that says which colour is how many points."""
    single = isinstance(axes, Axes)
    _, most = faces.get_clim()
    ticks = [t for power in (1, 10, 100, 1000) for t in (power, 2 * power, 5 * power) if t <= most]
    bar = figure.colorbar(faces, ax=axes, shrink=0.75 if single else 0.4, aspect=20 if single else 40, pad=0.02)
    bar.set_ticks(ticks, labels=[str(t) for t in ticks])
    bar.ax.minorticks_off()
    bar.set_label("points in a voxel")


def _viewer() -> np.ndarray:
    """The rows of a (3, 3) array: right and up in the drawing, and towards the viewer, in the camera's axes."""
    azimuth, elevation = np.radians([_AZIMUTH_DEG, _ELEVATION_DEG])
    level = np.sin(azimuth) * np.array(_RIGHT) - np.cos(azimuth) * np.array([0, 0, 1])
    toward = np.cos(elevation) * level + np.sin(elevation) * np.array(_TOP)
    right = np.cross(_TOP, toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right), toward])


def _visible_faces(grid: np.ndarray, toward: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The faces (F, 4, 3) that no neighbour covers, back to front; their voxels' values; which axis each is across."""
    padded = np.pad(grid > 0, 1)
    corners, voxels, across = [], [], []
    for axis in range(3):
        step = 1 if toward[axis] > 0 else -1
        covered = np.roll(padded, -step, axis)[1:-1, 1:-1, 1:-1]
        seen = np.argwhere((grid > 0) & ~covered)  # (F, 3)
        square = np.zeros((4, 3))
        square[:, [i for i in range(3) if i != axis]] = [(0, 0), (1, 0), (1, 1), (0, 1)]
        square[:, axis] = max(step, 0)
        corners.append(seen[:, None] + square)
        voxels.append(seen)
        across.append(np.full(len(seen), axis))
    cells = np.concatenate(voxels)
    order = np.argsort(cells @ toward, kind="stable")
    cells = cells[order]
    return np.concatenate(corners)[order], grid[tuple(cells.T)], np.concatenate(across)[order]


def _far_edges(div: int, toward: np.ndarray) -> np.ndarray:
    """The edges (9, 2, 3) of the cube that do not meet in the corner nearest to the viewer."""
    nearest = tuple((toward > 0).astype(int))
    ends = list(product((0, 1), repeat=3))
    edges = [(a, b) for a in ends for b in ends if a < b and sum(i != j for i, j in zip(a, b, strict=True)) == 1]
    return div * np.array([edge for edge in edges if nearest not in edge], float)
