"""The voxel grid of a view (thesis 3.1, equations 3.18 to 3.22): how many points lie where, relative to their extent.

Views of different lengths are worked on together: the points of all of them in one array, a row of `lengths` telling
how many belong to each. Sums of a view run in the order of its points.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
import torch
from pydantic import Field, PositiveInt


@dataclass(frozen=True)
class VoxelSettings:
    """How a view becomes the network's input."""

    div: PositiveInt = 32  # voxels along each side, thesis 3.1
    values: Literal["counts", "occupancy", "density"] = "counts"  # thesis 3.1: the number of points in a voxel
    # `density` (not in the thesis): counts over their mean in the view's occupied voxels, so that a scan twice as fine
    # or a camera twice as near gives the same grid
    # `trim` (not in the thesis): the share of points, farthest from the centroid, that is left out: a single stray one
    # would shrink all others into the middle of the grid
    trim: Annotated[float, Field(ge=0, lt=1)] = 0.0


@dataclass(frozen=True, eq=False)
class Clouds:
    """Views of any lengths on a torch device."""

    points: torch.Tensor  # (N, 3) float32 [m], a view after the other
    lengths: torch.Tensor  # (B,) int64, at least 1 each
    weights: torch.Tensor | None = None  # (N,) float32: how many measured points each stands for; None: one

    @cached_property
    def view(self) -> torch.Tensor:
        """The number of the view (N,) that each point belongs to."""
        numbers = torch.arange(len(self.lengths), device=self.lengths.device)
        return numbers.repeat_interleave(self.lengths, output_size=len(self.points))

    @cached_property
    def spheres(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Each view's centroid and radius, as `bounding_spheres` gives them."""
        return bounding_spheres(self)


def trim(points: np.ndarray, share: float) -> np.ndarray:
    """Points (N, 3) without the share of them that is farthest from their centroid."""
    dropped = int(np.ceil(share * len(points)))
    if dropped == 0 or dropped >= len(points):
        return points
    relative = points - points.mean(axis=0, dtype=np.float64).astype(points.dtype)
    squares = np.einsum("ij,ij->i", relative, relative)
    farthest = len(points) - dropped - 1
    return points[squares <= np.partition(squares, farthest)[farthest]]


def pack(clouds: list[np.ndarray], device: torch.device | str = "cpu") -> Clouds:
    """Finite points (N_i, 3) of several views as one batch."""
    points = torch.from_numpy(np.concatenate(clouds).astype(np.float32))
    return Clouds(points.to(device), torch.tensor([len(cloud) for cloud in clouds], device=device))


def bounding_spheres(clouds: Clouds) -> tuple[torch.Tensor, torch.Tensor]:
    """Centroids (B, 3) and the distance r (B,) from them to each view's farthest point [m] (3.18)."""
    view = clouds.view
    sums = torch.zeros(len(clouds.lengths), 3, dtype=torch.float64, device=view.device)
    centroids = (sums.index_add_(0, view, clouds.points.double()) / clouds.lengths[:, None]).float()
    distances = (clouds.points - centroids[view]).norm(dim=1)
    radii = torch.zeros(len(clouds.lengths), device=view.device).scatter_reduce_(0, view, distances, "amax")
    return centroids, radii


def voxel_indices(clouds: Clouds, div: int) -> torch.Tensor:
    """The voxel (N, 3) of each point, 0 to div - 1 on every axis (3.19 to 3.22).

    The grid is the cube of side 2r about the centroid; a point at its very edge belongs to voxel div - 1. Views
    without extent lie in the middle.
    """
    centroids, radii = clouds.spheres
    view = clouds.view
    side = torch.where(radii > 0, 2 * radii, 1)[view, None]
    corner = centroids[view] - side / 2  # (3.19)
    return ((clouds.points - corner) * (div / side)).long().clamp_(0, div - 1)


def voxel_grids(clouds: Clouds, settings: VoxelSettings | None = None) -> torch.Tensor:
    """The grids (B, 1, div, div, div) float32 of the views, axes x, y, z: points in every voxel, or what `values` says.

    Counts sum to a view's number of points.
    """
    settings = settings or VoxelSettings()
    div = settings.div
    x, y, z = voxel_indices(clouds, div).unbind(dim=1)
    cells = ((clouds.view * div + x) * div + y) * div + z
    weights = torch.ones_like(clouds.points[:, 0]) if clouds.weights is None else clouds.weights
    grids = torch.zeros(len(clouds.lengths) * div**3, device=weights.device).index_add_(0, cells, weights)
    grids = grids.reshape(-1, 1, div, div, div)
    if settings.values == "occupancy":
        return (grids > 0).float()
    if settings.values == "density":
        occupied = (grids > 0).sum(dim=(1, 2, 3, 4), keepdim=True)
        return grids * occupied / grids.sum(dim=(1, 2, 3, 4), keepdim=True)
    return grids
