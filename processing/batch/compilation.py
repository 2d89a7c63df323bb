"""The numba kernels that `process` needs, compiled before they are: once on a machine, then read from numba's cache."""

import logging
from contextlib import suppress
from pathlib import Path

import numpy as np

from orbitscan.processing import kernels, registration, surface
from orbitscan.processing.features import keypoints, shot
from orbitscan.processing.pipeline import process
from orbitscan.recorder.kernels import is_kept, kernels_of
from orbitscan.recorder.session import SessionInfo, View, in_memory

USED = [room.__name__ for room in (surface, kernels, registration, keypoints, shot)]  # where the page's kernels stand


def compiled() -> bool:
    """Whether every kernel lies in the cache, newer than every source that holds kernels.

    numba looks at a kernel's own file alone: where one that it calls has changed, it would run the old one.
    """
    newest = _newest_source()
    return all(is_kept(kernel, newest) for kernel in kernels_of(*USED))


def ensure_compiled() -> None:
    """Compile the kernels where they are not, and say so first."""
    if not compiled():
        logging.getLogger(__name__).warning("Compiling the kernels: once on this machine, about 10 s ...")
        compile_kernels()


def compile_kernels() -> None:
    """Compile, or load from the cache, every kernel by using it once on a small scan."""
    newest = _newest_source()
    for folder in {kernel.stats.cache_path for kernel in kernels_of(*USED)} - {None}:
        for file in Path(folder).glob("*.nb[ic]"):
            with suppress(FileNotFoundError):  # another process compiles at the same time
                if file.stat().st_mtime < newest:
                    file.unlink()
    rng = np.random.default_rng(0)
    u = rng.normal(size=(4000, 3))
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    points = u * (0.1 + 0.03 * np.sin(9 * u[:, :1]) * np.cos(7 * u[:, 1:2])) + [0, 0, 1]
    views = [View(i, str(i), i, points[points[:, 2] < 1.03].astype(np.float32)) for i in range(2)]
    list(process(in_memory(SessionInfo("", 2), views).views(), SessionInfo("", 2)))


def _newest_source() -> float:
    """When the youngest of the files that hold kernels, or stand beside one that does, was written [s]."""
    folders = {Path(kernel.py_func.__code__.co_filename).parent for kernel in kernels_of(*USED)}
    return max(path.stat().st_mtime for folder in folders for path in folder.glob("*.py"))
