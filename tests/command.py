"""The command `orbitscan` as a user types it, run in the test's own process: another one would import for seconds.

`start` runs it as a process, for what only a process shows: signals, broken pipes, threads that are set by the
environment, what is imported.
"""

import os
import subprocess
import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, chdir, contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO
from unittest.mock import patch

import numba
import torch

from orbitscan.processing.cli import main

ORBITSCAN = Path(sys.executable).with_name("orbitscan")


def run(*arguments: object, cwd: Path, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command in a folder, with more environment; everything that it sets for the process is as before after.

    An exception that the command lets pass, which would be a traceback on a terminal, is raised.
    """
    words = ["orbitscan", *map(str, arguments)]
    with ExitStack() as stack:
        stack.enter_context(_threads_and_random_numbers_of_its_own())
        stack.enter_context(patch.dict(os.environ, env or {}))
        stack.enter_context(patch.object(sys, "argv", words))
        stack.enter_context(chdir(cwd))
        out, err = stack.enter_context(_caught("stdout", 1)), stack.enter_context(_caught("stderr", 2))
        stack.enter_context(_warnings_as_a_user_sees_them())
        try:
            main()
            status = 0
        except SystemExit as ended:
            status = ended.code or 0
        return subprocess.CompletedProcess(words, status, _text(out), _text(err))


def start(*arguments: object, cwd: Path, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command as a process of its own."""
    words = [ORBITSCAN, *map(str, arguments)]
    return subprocess.run(words, cwd=cwd, env=os.environ | (env or {}), capture_output=True, text=True)


@contextmanager
def _threads_and_random_numbers_of_its_own() -> Iterator[None]:
    of_numba, of_torch = numba.get_num_threads(), torch.get_num_threads()
    try:
        with torch.random.fork_rng(devices=[]):
            yield
    finally:
        numba.set_num_threads(of_numba)
        torch.set_num_threads(of_torch)


@contextmanager
def _caught(name: str, descriptor: int) -> Iterator[IO[bytes]]:
    """What is written to a standard stream: by Python, by native libraries, and by processes that are started."""
    before = getattr(sys, name)
    before.flush()
    kept = os.dup(descriptor)
    with TemporaryFile() as file, os.fdopen(os.dup(file.fileno()), "w", encoding="utf-8") as stream:
        os.dup2(file.fileno(), descriptor)
        setattr(sys, name, stream)
        try:
            yield file
        finally:
            setattr(sys, name, before)
            os.dup2(kept, descriptor)
            os.close(kept)


def _text(caught: IO[bytes]) -> str:
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    caught.seek(0)
    return caught.read().decode("utf-8")


@contextmanager
def _warnings_as_a_user_sees_them() -> Iterator[None]:
    """On stderr, not in the test's summary; of numbers that are none, an error, as in every test."""

    def show(message, category, filename, lineno, file=None, line=None):
        print(warnings.formatwarning(message, category, filename, lineno, line), file=sys.stderr, end="")

    with warnings.catch_warnings():
        warnings.resetwarnings()
        for hidden in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", hidden)
        warnings.simplefilter("error", RuntimeWarning)
        warnings.showwarning = show
        yield
