"""Variations of training views that another sensor, another place or another copy of the thing would bring.

None is in the thesis; all are drawn anew each time a view is trained on.
"""

from dataclasses import dataclass, replace

import torch

from orbitscan.processing.classification.voxels import Clouds, bounding_spheres

_SIDEWAYS_DEG = 45.0  # the elevation taken for a camera whose own is not known


@dataclass(frozen=True)
class AugmentationSettings:
    """How much views are varied; 0 leaves a thing as it is. Lengths are relative to a view's radius r."""

    turn_deg: float = 0.0  # about the vertical, at most, to either side
    tilt_deg: float = 0.0  # about the camera's x axis, at most: another elevation
    roll_deg: float = 0.0  # about its viewing direction
    level: float = 0.0  # chance that a view is turned upright, as if its frame were level and not the camera's
    stretch: float = 0.0  # of each axis, at most by this share
    crop: float = 0.0  # at most of the height is lost below, as to a table
    occlusion: float = 0.0  # at most of the extent is lost on some side, in every other view
    thin: float = 0.0  # at most of the points are lost, evenly
    noise: float = 0.0  # standard deviation of every point, at most
    strays: float = 0.0  # chance that a view has a few points off its surface, which stretch its grid


def augment(clouds: Clouds, up: torch.Tensor, settings: AugmentationSettings, generator: torch.Generator) -> Clouds:
    """Copies of centred views of radius 1, varied at random; `up` (B, 3) is their vertical, NaN where not known."""
    if settings == AugmentationSettings():
        return clouds
    clouds = _keep(clouds, _survivors(clouds, up, settings, generator))
    view, size, device = clouds.view, len(clouds.lengths), clouds.points.device

    def draw(*shape: int) -> torch.Tensor:
        return torch.rand(*shape, generator=generator, device=device)

    def within(limit: float, *shape: int) -> torch.Tensor:
        return limit * (2 * draw(*shape) - 1)

    vertical = _vertical(up)
    turn = rotations(vertical, torch.deg2rad(within(settings.turn_deg, size)))
    x, _, z = torch.eye(3, device=device).expand(size, 3, 3).unbind(1)
    elevation = torch.atan2(-vertical[:, 2], -vertical[:, 1])  # negative for a camera that looks up
    upright = (draw(size) < settings.level) * elevation
    tilt = rotations(x, -upright) @ rotations(x, torch.deg2rad(within(settings.tilt_deg, size)))
    roll = rotations(z, torch.deg2rad(within(settings.roll_deg, size)))
    motion = roll @ tilt @ turn @ torch.diag_embed(1 + within(settings.stretch, size, 3))
    points = (motion[view] @ clouds.points[:, :, None])[:, :, 0]
    sigma = settings.noise * draw(size)[view, None]
    points = points + sigma * torch.randn(points.shape, generator=generator, device=device)
    stray = (draw(size) < settings.strays)[view] & (draw(len(points)) < 3 / clouds.lengths[view])
    points = torch.where(stray[:, None], points * (1 + 0.3 * draw(len(points), 1)), points)
    return replace(clouds, points=points)


def rotations(axes: torch.Tensor, angles: torch.Tensor) -> torch.Tensor:
    """The rotations (B, 3, 3) about unit axes (B, 3) by angles (B,) [rad], right-handed."""
    cross = torch.linalg.cross(torch.eye(3, device=axes.device).expand(len(axes), 3, 3), axes[:, None], dim=2)
    return torch.linalg.matrix_exp(angles[:, None, None] * cross)


def _vertical(up: torch.Tensor) -> torch.Tensor:
    elevation = torch.deg2rad(torch.tensor(_SIDEWAYS_DEG))
    usual = torch.stack([torch.zeros(()), -elevation.cos(), -elevation.sin()]).to(up)
    return torch.where(up.isnan().any(dim=1, keepdim=True), usual, up)


def _survivors(
    clouds: Clouds, up: torch.Tensor, settings: AugmentationSettings, generator: torch.Generator
) -> torch.Tensor:
    """Which points (N,) bool neither the table, nor something before the view, nor thinning takes away."""
    view, size, device = clouds.view, len(clouds.lengths), clouds.points.device
    directions = torch.randn(size, 3, generator=generator, device=device)
    directions = directions / directions.norm(dim=1, keepdim=True)
    luck = torch.rand(5, size, generator=generator, device=device)
    low = settings.crop * luck[0]
    side = settings.occlusion * luck[1] * (luck[2] < 0.5)
    kept = torch.rand(len(view), generator=generator, device=device) >= (settings.thin * luck[3])[view]
    for direction, share in ((_vertical(up), low), (directions, side)):
        along = (clouds.points * direction[view]).sum(dim=1)
        far = torch.full((2, size), torch.inf, device=device)
        least = far[0].scatter_reduce(0, view, along, "amin")
        most = (-far[1]).scatter_reduce(0, view, along, "amax")
        kept &= along >= (least + share * (most - least))[view]
    return kept


def _keep(clouds: Clouds, kept: torch.Tensor) -> Clouds:
    """The kept points, every view centred and of radius 1 again; a view that would lose nearly all stays whole."""
    view = clouds.view
    left = torch.zeros_like(clouds.lengths).index_add_(0, view, kept.long())
    kept = kept | (left < 16)[view]
    lengths = torch.zeros_like(clouds.lengths).index_add_(0, view, kept.long())
    weights = None if clouds.weights is None else clouds.weights[kept]
    clouds = Clouds(clouds.points[kept], lengths, weights)
    centroids, radii = bounding_spheres(clouds)
    view = clouds.view
    return replace(clouds, points=(clouds.points - centroids[view]) / radii.clamp_min(1e-9)[view, None])
