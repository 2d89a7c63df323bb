"""Files and folders that appear whole or not at all, whatever kills the process that makes them."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from orbitscan.recorder.exceptions import UnwritableOutput, Wording

Failures = type[Exception] | tuple[type[Exception], ...]


@contextmanager
def whole_file(
    path: Path, *, keep_suffix: bool = False, failures: Failures = (OSError, RuntimeError)
) -> Iterator[Path]:
    """`<path>.part` to be written, which takes the place of `path` when the block ends; its folder is made.

    The file is on the disk before it is renamed; where the block raises it is removed. With `keep_suffix` it is
    `<stem>.part<suffix>`, for writers that go by the suffix. Raises UnwritableOutput for `failures` of the writer:
    Rerun's and torch's are RuntimeErrors.
    """
    part = path.with_suffix(f".part{path.suffix}") if keep_suffix else path.with_name(f"{path.name}.part")
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        yield part
        _flush_file(part)
        part.replace(path)
    except BaseException as error:
        with suppress(OSError):  # it may stand where nothing can: in a file, in a folder that is read-only
            part.unlink(missing_ok=True)
        if isinstance(error, failures):
            raise unwritable(path, error) from None
        raise


def unwritable(path: Path, error: Exception) -> UnwritableOutput:
    """What is told where a file cannot be written; Rerun's and torch's errors have a text alone."""
    reason = getattr(error, "strerror", None) or next(iter(str(error).splitlines()), type(error).__name__)
    return UnwritableOutput(path, f"cannot be written ({reason})", Wording("choose another {place}"))


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a text or bytes. Raises UnwritableOutput."""
    with whole_file(path) as part:
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
            _flush_file(path)
    _flush_entries(folder)


def _flush_file(path: Path) -> None:
    with path.open("r+b") as stream:
        os.fsync(stream.fileno())


def _flush_entries(folder: Path) -> None:
    """A folder's own entries; Windows has no such call, and needs none."""
    if os.name == "posix":
        entries = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(entries)
        finally:
            os.close(entries)
