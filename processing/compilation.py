"""The numba kernels, compiled before they are needed: once on a machine, then read from numba's cache."""

from pathlib import Path
from typing import Any

import numpy as np

from processing.features import keypoints, normals, shot
from processing.reconstruction import ransac

KERNELS = (normals._normals, keypoints._saliency, keypoints._is_largest, shot._describe, ransac._count_inliers)


def compiled() -> bool:
    """Whether every kernel lies in the cache, newer than its source."""
    return all(map(_is_cached, KERNELS))


def compile_kernels() -> None:
    """Compile, or load from the cache, every kernel by using it once on a small cloud."""
    rng = np.random.default_rng(0)
    points = rng.random((200, 3))
    facing = normals.estimate_normals(points, 1.0, np.zeros(3))
    keypoints.detect_keypoints(points, 1.0, 1.0, keypoints.KeypointSettings())
    shot.describe(points, facing, points[:5], 1.0)
    ransac.estimate_pose(points, points, 0.01, ransac.RansacSettings(), rng)


def _is_cached(kernel: Any) -> bool:
    source = Path(kernel.py_func.__code__.co_filename)
    index = Path(kernel.stats.cache_path).glob(f"{source.stem}.{kernel.py_func.__qualname__}-*.nbi")
    return any(file.stat().st_mtime >= source.stat().st_mtime for file in index)
