"""A cloud file -> its points and colours: PLY, PCD, XYZ, CSV and NPY.

Open3D's readers are not used: a file that is cut comes out of them whole, what it lacks filled with zeros or stray
memory, and its coordinates in doubles come out as zeros from the older of the two. Here a file holds what it declares,
or is an error.
"""

from pathlib import Path

import numpy as np

from recorder.exceptions import UnreadableCloud
from recorder.sources import pcd_file, ply_file
from recorder.sources.point_table import RGB_FIELDS, read_numbers, split_columns

_REMEDY = "copy it again or leave it out"


def read(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) of a cloud file, in its own units and axes, NaN as found, and their colours (N, 3) uint8.

    Raises UnreadableCloud for a file of another kind, one that is damaged, and one that holds less than it declares.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise UnreadableCloud(path, "no cloud format that is known", f"give one of {' '.join(READERS)}")
    try:
        if path.stat().st_size == 0:
            raise UnreadableCloud(path, "the file is empty", _REMEDY)
        return reader(path)
    except OSError as error:
        raise UnreadableCloud(path, f"cannot be read ({error.strerror or error})", "check the file") from None
    except (ValueError, EOFError, OverflowError, IndexError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UnreadableCloud(path, f"no readable {path.suffix[1:].upper()} cloud ({reason})", _REMEDY) from None


def _read_text(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """XYZ and CSV: x y z [r g b] separated by blanks, commas or semicolons; a line of names may say which columns."""
    lines = [line for line in path.read_text(errors="replace").splitlines() if line.strip()]
    start = next((i for i, line in enumerate(lines) if _is_point(line)), None)
    if start is None:
        raise ValueError("it holds no line of three numbers")
    separator = _separator(lines[start])
    columns = list(range(min(6, len(lines[start].split(separator)))))
    if start > 0:
        names = [word.strip(" \t\"'#/").lower() for word in lines[start - 1].split(separator)]
        if {"x", "y", "z"} <= set(names):
            colors = next((rgb for rgb in RGB_FIELDS if set(rgb) <= set(names)), ())
            columns = [names.index(name) for name in ("x", "y", "z", *colors)]
    rows = [line for line in lines[start:] if not line.lstrip().startswith(("#", "//"))]
    return split_columns(read_numbers(rows, columns, separator))


def _separator(line: str) -> str | None:
    return next((mark for mark in ",;" if mark in line), None)


def _is_point(line: str) -> bool:
    words = line.split(_separator(line))
    try:
        float(words[0])
    except ValueError:
        return False
    return len(words) >= 3


def _read_npy(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """An array (..., 3 or more); the leading axes of an organised cloud are flattened."""
    array = np.load(path, allow_pickle=False)
    if array.ndim < 2 or array.shape[-1] < 3 or array.dtype.kind not in "fiu":
        raise ValueError(f"an array {array.shape} of {array.dtype}, not (N, 3) numbers")
    return split_columns(array.reshape(-1, array.shape[-1]))


READERS = {
    ".ply": ply_file.read,
    ".pcd": pcd_file.read,
    ".xyz": _read_text,
    ".csv": _read_text,
    ".npy": _read_npy,
}
