"""The recorder's commands. Each parses, calls the library and prints."""

import logging
import os
import sys
from collections.abc import Sequence
from typing import NoReturn

import typer

from orbitscan.recorder.cli import convert, inspect, simulate
from orbitscan.recorder.cli.output import complain
from orbitscan.recorder.exceptions import ScanError

COMMANDS = (convert.convert, simulate.simulate, inspect.info, inspect.check)


def run(app: typer.Typer, arguments: Sequence[str] | None = None) -> NoReturn:
    """Run a command line and exit; a ScanError is told in one line on stderr, and is status 2."""
    logger, lines = logging.getLogger("orbitscan"), logging.StreamHandler()  # to stderr, the messages alone
    logger.addHandler(lines)
    try:
        app(args=arguments, prog_name="orbitscan")
    except ScanError as error:
        complain(error)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
    except BrokenPipeError:
        sys.exit(1)
    finally:
        logger.removeHandler(lines)
        _flush()
    sys.exit(0)


def _flush() -> None:
    """Write out what was printed; where nobody reads any more, the interpreter's own last flush shall not complain."""
    out = sys.__stdout__
    if out is None:
        return
    try:
        out.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), out.fileno())
