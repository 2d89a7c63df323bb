"""A cloud file -> its points and colours: PLY, PCD, XYZ, CSV and NPY.

Open3D's readers are not used: a file that is cut comes out of them whole, what it lacks filled with zeros or stray
memory, and its coordinates in doubles come out as zeros from the older of the two. Here a file holds what it declares,
or is an error.
"""

from pathlib import Path

import numpy as np

from orbitscan.recorder.exceptions import InvalidOption, UnreadableCloud, Wording, setting
from orbitscan.recorder.formats import pcd, ply
from orbitscan.recorder.formats.point_table import RGB_FIELDS, read_numbers, split_columns

Columns = tuple[str, str, str]  # the names of those that hold x, y and z

_REMEDY = "copy it again or leave it out"
_NORMALS = ("n", "normal", "normal_", "normals_")  # what stands before x, y, z in the names of normals


def read(path: Path, columns: Columns | None = None) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) of a cloud file, in its own units and axes, NaN as found, and their colours (N, 3) uint8.

    `columns` says which of a text file's named columns are x, y and z. Raises UnreadableCloud for a file of another
    kind, one that is damaged, and one that holds less than it declares; InvalidOption where such columns are not
    there, and where they are not said though several could be meant.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise UnreadableCloud(path, "not a known cloud format", f"give one of {' '.join(READERS)}")
    try:
        if path.stat().st_size == 0:
            raise UnreadableCloud(path, "the file is empty", _REMEDY)
        if reader is _read_text:
            return _read_text(path, columns)
        if columns is not None:
            raise InvalidOption(setting("columns", columns), f"{path} is no text file", "leave it out")
        return reader(path)
    except OSError as error:
        raise UnreadableCloud(path, f"cannot be read ({error.strerror or error})", "check the file") from None
    except (ValueError, EOFError, OverflowError, IndexError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UnreadableCloud(path, f"no readable {path.suffix[1:].upper()} cloud ({reason})", _REMEDY) from None


def _read_text(path: Path, chosen: Columns | None = None) -> tuple[np.ndarray, np.ndarray | None]:
    """XYZ and CSV: x y z [r g b] separated by blanks, commas or semicolons; a line of names may say which columns."""
    lines = [line for line in path.read_text(errors="replace").splitlines() if line.strip()]
    start = next((i for i, line in enumerate(lines) if _is_point(line)), None)
    if start is None:
        raise ValueError("it holds no line of three numbers")
    separator = _separator(lines[start])
    columns = list(range(min(6, len(lines[start].split(separator)))))
    head = lines[start - 1].split(separator) if start > 0 else []
    names = [word.strip(" \t\"'#/\ufeff").lower() for word in head]
    if axes := _choose_axes(path, names, chosen):
        colors = next((rgb for rgb in RGB_FIELDS if set(rgb) <= set(names)), ())
        columns = [names.index(name) for name in (*axes, *colors)]
    rows = [line for line in lines[start:] if not line.lstrip().startswith(("#", "//"))]
    return split_columns(read_numbers(rows, columns, separator))


def _choose_axes(path: Path, names: list[str], chosen: Columns | None) -> Columns | None:
    """The columns of x, y and z among the names of a file's columns; None where no names speak of them.

    Where none are called x, y and z it is the one triple that differs in these letters only, normals left out.
    """
    if chosen is not None:
        if missing := [name for name in chosen if name.lower() not in names]:
            there = f"no column {missing[0]} among {', '.join(names)}" if names else "no line of column names"
            raise InvalidOption(setting("columns", chosen), f"{path} has {there}", "name three that are there")
        x, y, z = (name.lower() for name in chosen)
        return x, y, z
    if {"x", "y", "z"} <= set(names):
        return "x", "y", "z"
    parts = [(name[:i], name[i + 1 :]) for name in names for i, letter in enumerate(name) if letter == "x"]
    parts = [(before, after) for before, after in parts if before not in _NORMALS]
    triples = [(f"{before}x{after}", f"{before}y{after}", f"{before}z{after}") for before, after in parts]
    found = [triple for triple in dict.fromkeys(triples) if set(triple) <= set(names)]
    if len(found) > 1:
        several = " and ".join(",".join(triple) for triple in found)
        raise InvalidOption(path, f"may hold its points in {several}", Wording("pass {columns}", columns=found[0]))
    return found[0] if found else None


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


READERS = {".ply": ply.read, ".pcd": pcd.read, ".xyz": _read_text, ".csv": _read_text, ".npy": _read_npy}
