"""Kernels over many points, on all threads: compiled by numba, shared out by Python."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

from numba import config, get_num_threads, njit

config.THREADING_LAYER = "workqueue"  # numba's own threads never run; looking for others warns of old libraries

_SLICES_PER_THREAD = 8  # enough to balance the load

kernel = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)


def over_slices(function: Callable[..., None], count: int, *arguments: Any) -> None:
    """Call function(start, stop, *arguments) for slices that cover range(count), on numba's number of threads.

    The function is a kernel that writes what belongs to its slice and nothing else, so that neither the number of
    threads nor their order shows. Half the compile time of numba's own parallel loops.
    """
    threads = get_num_threads()
    length = max(1, -(-count // (threads * _SLICES_PER_THREAD)))
    slices = [(start, min(start + length, count)) for start in range(0, count, length)]
    if threads == 1 or len(slices) < 2:
        function(0, count, *arguments)
        return
    for running in [_pool(threads).submit(function, *bounds, *arguments) for bounds in slices]:
        running.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Kept for all calls: to start threads takes longer than many a kernel."""
    return ThreadPoolExecutor(threads)
