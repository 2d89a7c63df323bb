"""Commands run in this process: how they end, how long they take."""

import contextlib
import faulthandler
import io
import signal
import sys
import time
import traceback
from collections.abc import Iterator
from dataclasses import dataclass

from orbitscan.processing.cli import app
from orbitscan.recorder.cli import run

LIMIT_S = 10.0


class TooSlow(BaseException):
    """A command took longer than its limit; no `except Exception` may hold it back."""


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    status: int | None  # None where it broke
    out: str
    err: str
    seconds: float
    broke: str = ""


def run_command(*arguments: str) -> Ended:
    """Run a command in this process, but no longer than the limit."""
    out, err = io.StringIO(), io.StringIO()
    status, broke, started = None, "", time.perf_counter()
    try:
        with _no_longer_than(LIMIT_S), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            run(app, list(arguments))
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except (Exception, TooSlow):
        broke = traceback.format_exc()
    return Ended(status, out.getvalue(), err.getvalue(), time.perf_counter() - started, broke)


@contextlib.contextmanager
def _no_longer_than(seconds: float) -> Iterator[None]:
    """Raise TooSlow in what takes longer; end the process, with all stacks shown, where even that does not help."""

    def interrupt(*_: object) -> None:
        raise TooSlow

    faulthandler.dump_traceback_later(3 * seconds, exit=True, file=sys.__stderr__)
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, interrupt)
        signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)
        faulthandler.cancel_dump_traceback_later()


def peak_mb() -> float:
    """The most memory that this process has taken so far; 0 where it cannot be told."""
    try:
        import resource
    except ImportError:  # Windows
        return 0.0
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e6
