"""Many recordings at a time, in processes: a broken one takes no other along, and none outlives its parent."""

from collections.abc import Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

import filelock
import numba

from orbitscan.processing.batch.recording import Job, Outcome, process_recording
from orbitscan.recorder.atomic import unwritable
from orbitscan.recorder.exceptions import InvalidOption, ProcessingFailed, Wording, setting
from orbitscan.recorder.workers import as_ready

LIFETIME = 24  # recordings of a worker: rerun keeps some megabytes of each, which only the process's end frees


def process_all(recordings: Sequence[Path], job: Job, workers: int = 1, *, isolated: bool = True) -> Iterator[Outcome]:
    """An Outcome for each recording as it is ready; with several workers in the order they finish.

    One that fails does not stop the others, nor does one whose worker dies (out of memory, a crash in a library). Not
    `isolated`, one worker is this process: it begins at once, and a crash is its own. Raises UnwritableOutput, and
    InvalidOption where another process is writing into the same results.
    """
    with _only_writer(job.results):
        if len(recordings) == 1 or (workers == 1 and not isolated):
            yield from (process_recording(path, job) for path in recordings)
            return
        for start in range(0, len(recordings), LIFETIME * workers):
            yield from _process_in_pool(recordings[start : start + LIFETIME * workers], job, workers)


def threads_per_worker(workers: int) -> int:
    """How many threads each of so many workers gets."""
    return max(1, numba.config.NUMBA_NUM_THREADS // workers)  # type: ignore[attr-defined]


def _process_in_pool(recordings: Sequence[Path], job: Job, workers: int) -> Iterator[Outcome]:
    """Outcomes as they come.

    A pool whose worker dies is lost as a whole, with all that it had not finished. A single worker takes recordings in
    their order: the first of them killed it. Of several workers each had begun one and was handed another: these are
    done again by a single one, and the rest as before.
    """
    waiting = list(recordings)
    while waiting:
        lost = []
        for path, future in as_ready(partial(process_recording, job=job), waiting, workers):
            try:
                yield future.result()
            except BrokenProcessPool:
                lost.append(path)
        waiting = [path for path in waiting if path in lost]
        if waiting and workers == 1:
            remedy = Wording("use fewer {workers} or {views}")
            error = ProcessingFailed(waiting[0], "its process died (out of memory?)", remedy)
            yield Outcome.failed(waiting[0], job, error)
            waiting = waiting[1:]
        elif waiting:
            suspects = 2 * workers + 1  # the pool hands out one more than it has workers
            yield from _process_in_pool(waiting[:suspects], job, 1)
            waiting = waiting[suspects:]


@contextmanager
def _only_writer(results: Path) -> Iterator[None]:
    """Two processes in one results folder would take each other's half-made results for what a killed one left."""
    path = results / ".orbitscan.lock"
    lock = filelock.FileLock(path, is_singleton=False)
    try:
        results.mkdir(parents=True, exist_ok=True)
        lock.acquire(timeout=0)
    except filelock.Timeout:
        remedy = Wording("wait for it, or choose another {place}")
        raise InvalidOption(setting("results", results), "another orbitscan is writing there", remedy) from None
    except OSError as error:
        raise unwritable(results, error) from None
    try:
        yield
    finally:
        with suppress(OSError):  # Windows removes nothing that is open
            path.unlink()
        lock.release()
