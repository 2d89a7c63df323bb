"""The facts of one cloud: how dense, how large, how far, how noisy."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

SAMPLE = 800  # points at which neighbourhoods are looked at
PATCH = 32  # neighbours of a noise patch
COPIES = 3  # of a point that are looked past


@dataclass(frozen=True)
class CloudFacts:
    """What a cloud measures; lengths in metres."""

    points: int
    resolution: float  # median distance from a point to its nearest neighbour
    extent: tuple[float, float, float]  # sides of the box that holds all but the outermost half percent on each side
    diameter: float  # the diagonal of that box
    distance: float  # of the centroid from the frame's origin
    noise: float  # standard deviation along the surface's normal
    patch: float  # median distance from a point to its PATCH-th neighbour: how far a neighbourhood of so many reaches


def finite(points: np.ndarray, colors: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) whose three coordinates are finite, float32 and contiguous, and their colours."""
    known = np.isfinite(points)
    if known.all():
        return np.ascontiguousarray(points, dtype=np.float32), None if colors is None else np.ascontiguousarray(colors)
    keep = known.all(axis=1)
    points = np.ascontiguousarray(points[keep], dtype=np.float32)
    return points, None if colors is None else np.ascontiguousarray(colors[keep])


def measure(points: np.ndarray) -> CloudFacts:
    """The facts of finite points (N, 3); zeros where there are too few to tell."""
    points = np.asarray(points, dtype=np.float64)
    if len(points) < 2:
        distance = float(np.linalg.norm(points.mean(axis=0))) if len(points) else 0.0
        return CloudFacts(len(points), 0.0, (0.0, 0.0, 0.0), 0.0, distance, 0.0, 0.0)
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    extent = high - low
    tree = cKDTree(points)
    sample = points[:: max(1, len(points) // SAMPLE)]
    noise, patch = _noise(points, tree, sample)
    return CloudFacts(
        points=len(points),
        resolution=_resolution(tree, sample),
        extent=(float(extent[0]), float(extent[1]), float(extent[2])),
        diameter=float(np.linalg.norm(extent)),
        distance=float(np.linalg.norm(points.mean(axis=0))),
        noise=noise,
        patch=patch,
    )


def _resolution(tree: cKDTree, sample: np.ndarray) -> float:
    distances, _ = tree.query(sample, k=COPIES + 2)
    apart = np.where(distances > 0, distances, np.inf).min(axis=1)  # a point's copies say nothing
    apart = apart[np.isfinite(apart)]
    return float(np.median(apart)) if len(apart) else 0.0


def _noise(points: np.ndarray, tree: cKDTree, sample: np.ndarray) -> tuple[float, float]:
    """(noise, patch): medians over patches of the residual of a quadric z = f(x, y) in the patch's own frame, and of
    the patch's reach.

    A quadric, because a plane takes the object's curvature for noise.
    """
    if len(points) <= PATCH:
        return 0.0, 0.0
    distances, neighbours = tree.query(sample, k=PATCH)
    patches = points[neighbours] - points[neighbours].mean(axis=1, keepdims=True)  # (S, K, 3)
    _, _, axes = np.linalg.svd(patches, full_matrices=False)
    local = np.einsum("skj,sij->ski", patches, axes)  # along the two spread axes, then the normal
    scale = np.abs(local[:, :, :2]).max(axis=(1, 2))
    keep = scale > 0
    x, y, z = (local[keep, :, i] / scale[keep, None] for i in range(3))
    A = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)  # (S, K, 6)
    normal = np.einsum("ski,skj->sij", A, A) + 1e-9 * np.eye(6)
    coefficients = np.linalg.solve(normal, np.einsum("ski,sk->si", A, z)[:, :, None])
    residual = (z - (A @ coefficients)[:, :, 0]) * scale[keep, None]
    sigma = np.sqrt((residual**2).sum(axis=1) / (PATCH - 6))
    return float(np.median(sigma)) if len(sigma) else 0.0, float(np.median(distances[:, -1]))
