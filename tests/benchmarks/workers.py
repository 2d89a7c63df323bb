"""Processes in which a benchmark runs several sessions at a time."""

import os
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context


@contextmanager
def pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """New processes that share the cores."""
    threads = str(max(1, (os.cpu_count() or 1) // workers))
    before = dict(os.environ)
    shared = dict.fromkeys(("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), threads)
    os.environ.update(shared)  # read by the libraries when a worker loads them
    try:
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as executor:
            yield executor
    finally:
        os.environ.clear()
        os.environ.update(before)
