"""A cloud in its object's frame, seen from a side without perspective."""

import numpy as np
from matplotlib.axes import Axes

SIDES = {  # name -> azimuth from the front (+x) counterclockwise seen from above, elevation [degrees]
    "front": (0, 0),
    "left": (90, 0),
    "rear": (180, 0),
    "right": (270, 0),
    "top": (0, 90),
    "bird's view": (35, 35),
}
_GREY = 0.45  # brightness of points without colour
_FADE = 0.45  # how much the farthest point is lighter than the nearest


def draw_cloud(axes: Axes, points: np.ndarray, side: str, half: float, colors: np.ndarray | None = None) -> None:
    """Points (N, 3) [m] from one of SIDES, far ones lighter and behind; the picture is 2 `half` [m] wide and high."""
    right, up, toward = _directions(*SIDES[side])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    relative = points - middle
    depth = relative @ toward
    order = np.argsort(depth)
    share = (depth - depth.min()) / max(np.ptp(depth), 1e-9)  # 0: the farthest
    own = np.full((len(points), 3), _GREY) if colors is None else colors / 255
    shaded = own + (1 - own) * (_FADE * (1 - share))[:, None]
    axes.scatter(
        (relative @ right)[order], (relative @ up)[order], s=2.4, c=shaded[order], linewidths=0, rasterized=True
    )
    axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
    axes.set_axis_off()


def _directions(azimuth_deg: float, elevation_deg: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right and up in the picture, and towards whoever looks."""
    azimuth, elevation = np.radians([azimuth_deg, elevation_deg])
    level = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    toward = np.cos(elevation) * level + np.array([0, 0, np.sin(elevation)])
    return right, np.cross(toward, right), toward
