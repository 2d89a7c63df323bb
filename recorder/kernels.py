"""Kernels: compiled by numba, their machine code kept from run to run, shared out over all threads by Python."""

import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba import get_num_threads

from orbitscan.recorder.caches import temporary_cache

config: Any = numba.config  # its stubs lack some
njit: Any = numba.njit
config.THREADING_LAYER = "workqueue"  # numba's own threads never run; looking for others warns of old libraries

_SLICES_PER_THREAD = 8  # enough to balance the load


def _choose_cache() -> bool:
    """Whether machine code can be kept: beside the sources, else with the user's caches, else in a temporary folder.

    numba knows the first two. Where neither can be written (a read-only installation, another user, no HOME) the third
    is made, told in one line, and handed to worker processes by the environment.
    """
    try:
        njit(cache=True)(_choose_cache)
    except RuntimeError:  # numba's "no locator available"
        logger = logging.getLogger(__name__)
        try:
            folder = temporary_cache("kernels")
        except OSError:
            logger.warning("compiled kernels cannot be kept anywhere: each run compiles them anew")
            return False
        logger.warning("compiled kernels are kept in %s: neither the installation nor a cache can be written", folder)
        config.CACHE_DIR = os.environ["NUMBA_CACHE_DIR"] = str(folder)
    return True


_compile = njit(cache=_choose_cache(), nogil=True, error_model="numpy", no_cfunc_wrapper=True)
_kernels: list[Any] = []  # of all modules imported so far


def kernel(function: Callable[..., Any]) -> Any:
    """Decorate a function to be compiled when it is first called, its machine code kept from run to run."""
    _kernels.append(_compile(function))
    return _kernels[-1]


def kernels_of(*modules: str) -> list[Any]:
    """The kernels of imported modules, or of all modules of imported packages, by name."""
    return [found for found in _kernels if f"{found.__module__}.".startswith(tuple(f"{name}." for name in modules))]


def is_kept(function: Any, since: float = 0.0) -> bool:
    """Whether a kernel's machine code was kept, at or after a time [s]."""
    if function.stats.cache_path is None:
        return False
    name = f"{Path(function.py_func.__code__.co_filename).stem}.{function.py_func.__qualname__}-*.nbi"
    return any(file.stat().st_mtime >= since for file in Path(function.stats.cache_path).glob(name))


def over_slices(function: Callable[..., None], count: int, *arguments: Any, threads: int = 0) -> None:
    """Call function(start, stop, *arguments) for slices that cover range(count), on `threads` (0: numba's number).

    The function is a kernel that writes what belongs to its slice and nothing else, so that neither the number of
    threads nor their order shows. Half the compile time of numba's own parallel loops.
    """
    threads = threads or get_num_threads()
    length = max(1, -(-count // (threads * _SLICES_PER_THREAD)))
    slices = [(start, min(start + length, count)) for start in range(0, count, length)]
    if threads == 1 or len(slices) < 2:
        function(0, count, *arguments)
        return
    for running in [_pool(threads).submit(function, *bounds, *arguments) for bounds in slices]:
        running.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """A pool of so many threads, kept for all calls: to start threads takes longer than many a kernel."""
    return ThreadPoolExecutor(threads)
