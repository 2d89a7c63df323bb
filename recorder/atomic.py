"""Files and folders that appear whole or not at all, whatever kills the process that makes them."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from orbitscan.recorder.exceptions import UnwritableOutput


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """`<path>.part` to be written, which takes the place of `path` when the block ends. Raises UnwritableOutput."""
    part = path.with_name(path.name + ".part")
    try:
        yield part
        part.replace(path)
    except (OSError, RuntimeError) as error:  # Rerun's are RuntimeErrors
        with suppress(OSError):  # it may stand where nothing can: in a file
            part.unlink(missing_ok=True)
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise UnwritableOutput(path, f"cannot be written ({reason})", "choose another place with -o") from None
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text or bytes, the folder too where there is none. Raises UnwritableOutput."""
    with whole_file(path) as part:
        part.parent.mkdir(parents=True, exist_ok=True)
        part.write_bytes(content.encode() if isinstance(content, str) else content)


@contextmanager
def whole_folder(folder: Path) -> Iterator[Path]:
    """An empty folder `<folder>.part` to be filled, which takes the place of `folder` when the block ends.

    Everything in it is on the disk before it is renamed; where the block raises it is removed, and `folder` is what it
    was. Raises OSError.
    """
    remove_leftovers(folder)
    part, replaced = _aside(folder)
    part.mkdir(parents=True)
    try:
        yield part
        _flush(part)
        if folder.exists():
            folder.replace(replaced)  # two renames: removing a folder takes time, and leaves half of it when killed
        part.replace(folder)
        _flush_entries(folder.parent)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise
    shutil.rmtree(replaced, ignore_errors=True)


def remove_leftovers(folder: Path) -> None:
    """Removes what a killed process left beside a folder; `folder` itself is whole, or is not there."""
    for left in _aside(folder):
        if left.exists():
            shutil.rmtree(left)


def _aside(folder: Path) -> tuple[Path, Path]:
    """Where a folder is made, and where the one that it replaces stands until it is removed."""
    return folder.with_name(folder.name + ".part"), folder.with_name(folder.name + ".part.old")


def _flush(folder: Path) -> None:
    for path in folder.rglob("*"):
        if path.is_file():
            with path.open("r+b") as stream:
                os.fsync(stream.fileno())
    _flush_entries(folder)


def _flush_entries(folder: Path) -> None:
    """A folder's own entries; Windows has no such call, and needs none."""
    if os.name == "posix":
        entries = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(entries)
        finally:
            os.close(entries)
