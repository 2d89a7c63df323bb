"""First filters from the views themselves: centres of whitened patches about ISS keypoints (thesis 3.2.3)."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import torch
from threadpoolctl import threadpool_limits

from orbitscan.processing.classification.network import Network
from orbitscan.processing.classification.voxels import VoxelSettings, bounding_spheres, pack, voxel_grids, voxel_indices
from orbitscan.processing.features.keypoints import KeypointSettings, detect_keypoints
from orbitscan.recorder import cloud
from orbitscan.recorder.exceptions import InvalidOption

Kind = Literal["pca", "zca"]  # of whitening
_STARTS = 3  # of k-means, the best of which counts


@dataclass(frozen=True)
class KMeansSettings:
    """How the first filters are found; where no section is named, the thesis leaves it open."""

    whitening: Kind = "pca"  # (3.25) or (3.26); table 5.4: PCA is the better one
    floor: float = 1e-6  # eigenvalues below this share of the largest are taken for zero
    back_project: bool = False  # lead the centres back to voxels, where a whitened patch is compared with them
    at_most: int = 10_000  # patches
    keypoints: KeypointSettings = field(
        default_factory=lambda: KeypointSettings(salient_radius=2.5, non_max_radius=1.0, at_most=50)
    )  # radii in multiples of a voxel's side, or of the view's resolution where that is larger; at most 50 a view


@dataclass(frozen=True, eq=False)
class Whitening:
    """The affine map of patches to decorrelated ones of unit variance."""

    mean: np.ndarray  # (d,)
    matrix: np.ndarray  # (d, d)
    kept: int  # directions that are not mapped to zero

    def apply(self, patches: np.ndarray) -> np.ndarray:
        """Patches (P, d), whitened."""
        return (patches - self.mean) @ self.matrix.T


def set_first_filters(
    network: Network, views: Sequence[np.ndarray], voxels: VoxelSettings, settings: KMeansSettings, seed: int
) -> None:
    """Replace the weights of the network's first convolution by filters found in the views (N_i, 3), in place.

    Raises InvalidOption where the network has no convolution, or the views too few patches.
    """
    if not network.convolutions:
        raise InvalidOption("k-means initialisation", "the structure has no convolution", "start it with C(32,5,2)")
    first = network.convolutions[0]
    filters = first_filters(views, first.out_channels, first.kernel_size[0], voxels, settings, seed)
    with torch.no_grad():
        first.weight.copy_(filters)


def first_filters(
    views: Sequence[np.ndarray], count: int, kernel: int, voxels: VoxelSettings, settings: KMeansSettings, seed: int
) -> torch.Tensor:
    """Filters (count, 1, k, k, k) float32: cluster centres of whitened patches, each scaled to Glorot's variance.

    The views (N_i, 3) [m] are looked at in random order until there are enough patches. Raises InvalidOption where
    they hold fewer different patches than there are filters.
    """
    from sklearn.cluster import KMeans

    found = collect(views, kernel, voxels, settings, seed)
    different = len(np.unique(found, axis=0))
    if different < count:
        problem = f"{different} different patches about keypoints for {count} filters"
        raise InvalidOption("k-means initialisation", problem, "train on more views, or start from glorot")
    whitening = whiten(found, settings.whitening, settings.floor)
    with threadpool_limits(limits=1):  # threads add up in any order
        centres = KMeans(count, n_init=_STARTS, random_state=seed).fit(whitening.apply(found)).cluster_centers_
    if settings.back_project:
        centres = centres @ whitening.matrix  # their product with a centred patch is the one in the whitened space
    glorot_std = np.sqrt(2 / ((1 + count) * kernel**3))
    size = np.sqrt((centres**2).mean(axis=1, keepdims=True))
    filters = glorot_std * centres / np.where(size > 0, size, 1)
    return torch.from_numpy(filters.astype(np.float32)).reshape(count, 1, kernel, kernel, kernel)


def collect(
    views: Sequence[np.ndarray], kernel: int, voxels: VoxelSettings, settings: KMeansSettings, seed: int
) -> np.ndarray:
    """Normalized patches (P, k^3) of the views (N_i, 3), taken in random order, at most `at_most`."""
    found = [np.empty((0, kernel**3))]
    count = 0
    for number in np.random.default_rng(seed).permutation(len(views)):
        points = np.asarray(views[number], np.float32)
        found.append(patches(points, voxel_grids(pack([points]), voxels)[0, 0].numpy(), kernel, settings.keypoints))
        count += len(found[-1])
        if count >= settings.at_most:
            break
    return np.concatenate(found)[: settings.at_most]


def patches(points: np.ndarray, grid: np.ndarray, kernel: int, settings: KeypointSettings) -> np.ndarray:
    """Normalized patches (P, k^3) of the grid (div, div, div) about the keypoints of its points (N, 3) [m]."""
    clouds = pack([points])
    div, radius = len(grid), float(bounding_spheres(clouds)[1])
    unit = max(2 * radius / div, cloud.measure(points).resolution)
    if unit == 0:
        return np.empty((0, kernel**3))
    keypoints = detect_keypoints(points, settings.salient_radius * unit, settings.non_max_radius * unit, settings)
    return normalize(cut(grid, np.unique(voxel_indices(clouds, div).numpy()[keypoints], axis=0), kernel))


def cut(grid: np.ndarray, voxels: np.ndarray, kernel: int) -> np.ndarray:
    """Patches (P, k^3) of the grid about voxels (P, 3), which are in their middle; zero lies beyond the border."""
    before = kernel // 2
    padded = np.pad(grid.astype(np.float64), (before, kernel - 1 - before))
    windows = np.lib.stride_tricks.sliding_window_view(padded, (kernel,) * 3)
    return windows[tuple(voxels.T)].reshape(len(voxels), kernel**3)


def normalize(patches: np.ndarray) -> np.ndarray:
    """Patches (P, d) of mean 0 and standard deviation 1 (local intensity); constant ones are left out."""
    patches = patches[np.ptp(patches, axis=1) > 0]
    return (patches - patches.mean(axis=1, keepdims=True)) / patches.std(axis=1, keepdims=True)


def whiten(patches: np.ndarray, kind: Kind, floor: float = 1e-6) -> Whitening:
    """The whitening of patches (P, d): L^-1/2 P^t (3.25) or P L^-1/2 P^t (3.26), for their covariance P L P^t.

    Eigenvalues, in falling order, below `floor` of the largest are mapped to zero.
    """
    mean = patches.mean(axis=0)  # (3.23)
    V = (patches - mean).T  # (3.24)
    L, P = np.linalg.eigh(V @ V.T / V.shape[1])
    L, P = L[::-1], P[:, ::-1]
    kept = int((L / L[0] > floor).sum())
    scale = np.zeros_like(L)
    scale[:kept] = L[:kept] ** -0.5
    pca = scale[:, None] * P.T
    return Whitening(mean, pca if kind == "pca" else P @ pca, kept)
