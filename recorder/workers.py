"""Work shared out over processes, of which none outlives its parent."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def as_ready(
    work: Callable[[Item], Result], items: Iterable[Item], workers: int
) -> Iterator[tuple[Item, Future[Result]]]:
    """Each item with its finished future, in the order they finish; `work` is what another process can import.

    Where the caller leaves early, or is interrupted, what waits is not begun and what is under way is ended. A worker
    that dies breaks the pool: the futures of all that it had not finished raise BrokenProcessPool.
    """
    # spawn: forked children hang in libraries that had already started threads
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_begin_worker) as pool:
        pending = {pool.submit(work, item): item for item in items}
        try:
            for future in as_completed(pending):
                yield pending[future], future
        except BaseException:
            for future in pending:
                future.cancel()
            for process in multiprocessing.active_children():
                process.terminate()
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _begin_worker() -> None:
    """An interrupt is the parent's to handle; and a worker whose parent was killed ends, whatever it is doing."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None  # this is a worker
    parent.join()
    os._exit(1)
