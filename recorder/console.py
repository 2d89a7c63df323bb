"""What the command shows: tables in one style, and how far long work is: a bar on a terminal, lines in a log."""

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from rich.text import Text

Item = TypeVar("Item")
SILENCE = 60.0  # seconds between the lines of a log


def print_table(title: str, columns: Mapping[str, Mapping[str, Any]], rows: Sequence[Sequence["str | Text"]]) -> None:
    """Print rows; columns are the options of Rich's `add_column` by their header. Without rows nothing.

    Headers and cells are shown as they are: [mm] and a session named [a] are no markup.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    if not rows:
        return
    table = Table(title=Text(title), title_justify="left", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for name, options in columns.items():
        table.add_column(Text(name), **options)
    for row in rows:
        table.add_row(*(cell if isinstance(cell, Text) else Text(cell) for cell in row))
    Console().print(table)


def progress(items: Iterable[Item], total: int, what: str) -> Iterator[Item]:
    """Yields the items and shows how many of `total` are done; `what` names the work."""
    with counter(total, what) as advance:
        for item in items:
            yield item
            advance()


@contextmanager
def counter(total: int, what: str) -> Iterator[Callable[[], None]]:
    """A function that counts one more step of `total`, and shows how far the work named `what` is."""
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
