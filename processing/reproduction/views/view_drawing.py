"""A view as its camera saw it: each point where it lies in the image, in its colour."""

import numpy as np
from matplotlib.axes import Axes

from orbitscan.recorder.session import View

_GREY = "0.45"  # of points without colour
_MARGIN = 1.08
_LEAST = 1e-6  # half side of the picture of a single point
_CELLS = 24  # across a view, to tell how much of its square it fills


def picture_size(view: View) -> float:
    """Half the side of the square picture that holds a view, as a tangent."""
    _, places = _project(view)
    return max(float(np.ptp(places, axis=0).max() / 2), _LEAST) * _MARGIN


def draw_view(axes: Axes, view: View, inches: float = 1.0, half: float | None = None) -> None:
    """Draw a view in the middle of axes about `inches` wide, its points so large that neighbours meet.

    `half`: see `picture_size`; None: the view's own.
    """
    known, places = _project(view)
    low, high = places.min(axis=0), places.max(axis=0)
    middle, side = (low + high) / 2, max((high - low).max(), 2 * _LEAST)
    half = picture_size(view) if half is None else half
    cells = np.unique(np.rint((places - low) / side * _CELLS), axis=0)
    spacing = side / _CELLS * np.sqrt(len(cells) / len(places))  # of the points, as a tangent
    size = 1.3 * spacing / (2 * half) * inches * 72
    colors = _GREY if view.colors is None else view.colors[known] / 255
    axes.scatter(places[:, 0], places[:, 1], s=size**2, c=colors, marker="s", linewidths=0, rasterized=True)
    axes.set(xlim=middle[0] + [-half, half], ylim=middle[1] + [-half, half], aspect="equal")
    axes.set_axis_off()


def _project(view: View) -> tuple[np.ndarray, np.ndarray]:
    """Which points (N,) lie before the camera, and their places (M, 2) in the image: right, up."""
    known = np.isfinite(view.points).all(axis=1)
    known[known] = view.points[known, 2] > 0
    points = view.points[known].astype(np.float64)
    return known, points[:, :2] / points[:, 2:] * (1, -1)
