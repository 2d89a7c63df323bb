"""How far long work is: a bar on a terminal, a plain line now and then in a log."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TypeVar

Item = TypeVar("Item")
SILENCE = 60.0  # seconds between the lines of a log


def progress(items: Iterable[Item], total: int, what: str) -> Iterator[Item]:
    """The items, counted."""
    with counter(total, what) as advance:
        for item in items:
            yield item
            advance()


@contextmanager
def counter(total: int, what: str) -> Iterator[Callable[[], None]]:
    """What counts one step of so many."""
    if not sys.stderr.isatty():
        yield _log(total, what)
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, redirect_stdout=sys.stdout.isatty()) as bar:
        task = bar.add_task(what, total=total)
        yield lambda: bar.advance(task)


def _log(total: int, what: str) -> Callable[[], None]:
    done, last = 0, time.monotonic()

    def advance() -> None:
        nonlocal done, last
        done += 1
        if time.monotonic() - last >= SILENCE:
            last = time.monotonic()
            print(f"{what}: {done} of {total}", file=sys.stderr, flush=True)

    return advance
