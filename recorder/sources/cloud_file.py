"""A cloud file -> its points and colours: PLY, PCD, XYZ, CSV and NPY.

Open3D's readers are not used: a file that is cut comes out of them whole, what it lacks filled with zeros or stray
memory, and its coordinates in doubles come out as zeros from the older of the two. Here a file holds what it declares,
or is an error.
"""

import os
import struct
from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import IO

import numpy as np

from recorder.exceptions import UnreadableCloud

_PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float": "f4", "double": "f8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_PLY_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
_PCD_TYPES = {"F": "f", "I": "i", "U": "u"}
_RGB = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
_PACKED_RGB = ("rgb", "rgba")  # 0x00RRGGBB in four bytes, as PCL packs them
_CUT = "copy it again or leave it out"


def read(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) of a cloud file, in its own units and axes, NaN as found, and their colours (N, 3) uint8.

    In XYZ and NPY the fourth to sixth column are colours where they hold whole numbers from 0 to 255, not all below 2
    (else they are normals, and left out). Raises UnreadableCloud.
    """
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise UnreadableCloud(path, "no cloud format that is known", f"give one of {' '.join(READERS)}")
    try:
        if path.stat().st_size == 0:
            raise UnreadableCloud(path, "the file is empty", _CUT)
        return reader(path)
    except OSError as error:
        raise UnreadableCloud(path, f"cannot be read ({error.strerror or error})", "check the file") from None
    except (ValueError, EOFError, OverflowError, IndexError, struct.error) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UnreadableCloud(path, f"no readable {path.suffix[1:].upper()} cloud ({reason})", _CUT) from None


def _read_ply(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    with path.open("rb") as stream:
        if stream.readline(80).strip() != b"ply":
            raise ValueError("it does not start with 'ply'")
        order, elements = _ply_header(stream)
        for name, count, fields in elements:
            has_lists = any(kind is None for _, kind in fields)
            layout = None if has_lists else np.dtype([(field, order + kind) for field, kind in fields])
            if name == "vertex":
                if layout is None:
                    raise ValueError("its vertices hold lists")
                table = _read_lines(stream, layout, count) if order == "=" else _read_bytes(stream, layout, count)
                return _split(path, table, count)
            if order == "=":
                next(islice(stream, count, count), None)  # skips the lines
            elif layout is None:
                raise ValueError(f"the lists of its element '{name}' stand before its vertices")
            else:
                stream.seek(count * layout.itemsize, 1)
    raise ValueError("it declares no vertices")


def _ply_header(stream: IO[bytes]) -> tuple[str, list[tuple[str, int, list[tuple[str, str | None]]]]]:
    """The byte order ('=' for text) and the elements: name, count, fields with their type (None for a list)."""
    order, elements = "", []
    for line in iter(lambda: stream.readline(4096), b""):
        match line.decode("ascii", "replace").split():
            case ["format", kind, *_] if kind in _PLY_ORDERS:
                order = _PLY_ORDERS[kind]
            case ["element", name, count]:
                elements.append((name, int(count), []))
            case ["property", "list", _, _, name] if elements:
                elements[-1][2].append((name, None))
            case ["property", kind, name] if elements and kind in _PLY_TYPES:
                elements[-1][2].append((name, _PLY_TYPES[kind]))
            case ["end_header"] if order:
                return order, elements
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(f"its header holds '{line[:40].decode('ascii', 'replace').strip()}'")
    raise ValueError("its header is cut")


def _read_pcd(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    header: dict[str, list[str]] = {}
    with path.open("rb") as stream:
        while "DATA" not in header:
            line = stream.readline(65536)
            if not line:
                raise ValueError("its header has no DATA line")
            if words := line.decode("ascii", "replace").split("#")[0].split():
                header[words[0]] = words[1:]
        missing = [key for key in ("FIELDS", "SIZE", "TYPE", "DATA") if not header.get(key)]
        if missing:
            raise ValueError(f"its header has no {missing[0]} line")
        layout = _pcd_layout(header)
        width, height = (int(header.get(key, ["1"])[0]) for key in ("WIDTH", "HEIGHT"))
        count = int(header["POINTS"][0]) if "POINTS" in header else width * height
        match header["DATA"][0]:
            case "ascii":
                table = _read_lines(stream, layout, count)
            case "binary":
                table = _read_bytes(stream, layout, count)
            case "binary_compressed":
                table = _read_compressed(stream, layout, count)
            case other:
                raise ValueError(f"its data are '{other}'")
    return _split(path, table, count)


def _pcd_layout(header: dict[str, list[str]]) -> np.dtype:
    """The layout of a point; a field of several numbers gets a column for each."""
    fields = header["FIELDS"]
    counts = header.get("COUNT", ["1"] * len(fields))
    layout = []
    for i, (name, size, kind, count) in enumerate(zip(fields, header["SIZE"], header["TYPE"], counts, strict=True)):
        if kind not in _PCD_TYPES:
            raise ValueError(f"its field {name} has the type '{kind}'")
        names = [name if int(count) == 1 and name != "_" else f"{name}.{i}.{k}" for k in range(int(count))]
        layout += [(unique, f"<{_PCD_TYPES[kind]}{size}") for unique in names]
    try:
        return np.dtype(layout)
    except TypeError as error:
        raise ValueError(f"its fields make no sense: {error}") from None


def _read_lines(lines: Iterable[bytes], layout: np.dtype, count: int) -> np.ndarray:
    """Up to `count` records written as text, a line each; columns beyond the layout are left out."""
    names = layout.names
    numbers = _numbers(islice(lines, count), list(range(len(names))))
    table = np.zeros(len(numbers), layout)
    with np.errstate(invalid="ignore"):  # a NaN among whole numbers
        for i, name in enumerate(names):
            table[name] = numbers[:, i].astype(layout[name])
    return table


def _numbers(lines: Iterable[bytes | str], columns: list[int], separator: str | None = None) -> np.ndarray:
    """The numbers (N, C) in columns of text; a line of blanks is left out."""
    filled = (line for line in lines if line.strip())
    first = next(filled, None)
    if first is None:
        return np.empty((0, len(columns)))
    return np.loadtxt(_chain(first, filled), comments=None, delimiter=separator, usecols=columns, ndmin=2)


def _chain(first: bytes | str, rest: Iterable[bytes | str]) -> Iterable[bytes | str]:
    yield first
    yield from rest


def _read_bytes(stream: IO[bytes], layout: np.dtype, count: int) -> np.ndarray:
    """Up to `count` whole records."""
    size = os.fstat(stream.fileno()).st_size  # a damaged count may be larger than any memory
    data = stream.read(min(count * layout.itemsize, size))
    return np.frombuffer(data, layout, len(data) // layout.itemsize)


def _read_compressed(stream: IO[bytes], layout: np.dtype, count: int) -> np.ndarray:
    """PCL's binary_compressed: LZF over all values of the first field, then all of the second, ..."""
    packed_size, size = struct.unpack("<II", stream.read(8))
    if size != count * layout.itemsize:
        raise ValueError(f"{size} bytes for {count} points of {layout.itemsize}")
    data = _decompress_lzf(stream.read(packed_size), size)
    table, start = np.zeros(count, layout), 0
    for name in layout.names:
        table[name] = np.frombuffer(data, layout[name], count, start)
        start += count * layout[name].itemsize
    return table


def _decompress_lzf(data: bytes, size: int) -> bytes:
    """Lehmann's LZF: a literal run, or a copy of (length, distance) from what is already out."""
    out, i = bytearray(), 0
    while i < len(data):
        control = data[i]
        i += 1
        if control < 32:
            out += data[i : i + control + 1]
            i += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[i]
            i += 1
        length += 2
        start = len(out) - ((control & 31) << 8) - data[i] - 1
        i += 1
        if start < 0:
            raise ValueError("its compressed data are damaged")
        while length > 0:  # a copy may overlap what it writes
            piece = out[start : start + length]
            out += piece
            start += len(piece)
            length -= len(piece)
    if len(out) != size:
        raise ValueError("its compressed data are cut")
    return bytes(out)


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
            colors = next((rgb for rgb in _RGB if set(rgb) <= set(names)), ())
            columns = [names.index(name) for name in ("x", "y", "z", *colors)]
    rows = [line for line in lines[start:] if not line.lstrip().startswith(("#", "//"))]
    return _split_columns(_numbers(rows, columns, separator))


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
    return _split_columns(array.reshape(-1, array.shape[-1]))


def _split_columns(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    rest = columns[:, 3:6]
    whole = (
        rest.shape == (len(columns), 3) and rest.size and bool(((rest >= 0) & (rest <= 255) & (rest % 1 == 0)).all())
    )
    return columns[:, :3], rest.astype(np.uint8) if whole and rest.max() > 1 else None


def _split(path: Path, table: np.ndarray, declared: int) -> tuple[np.ndarray, np.ndarray | None]:
    """The points and colours among the fields of a file that declares so many points."""
    if len(table) < declared:
        raise UnreadableCloud(path, f"is cut: {len(table):,} of the {declared:,} points it declares", _CUT)
    if not {"x", "y", "z"} <= set(table.dtype.names):
        raise UnreadableCloud(path, f"has no x y z among its fields ({' '.join(table.dtype.names)})", _CUT)
    points = np.stack([table[axis] for axis in "xyz"], axis=1)
    for packed in _PACKED_RGB:
        if packed in table.dtype.names and table.dtype[packed].itemsize == 4:
            bits = np.ascontiguousarray(table[packed]).view(np.uint32)
            return points, np.stack([(bits >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)], axis=1)
    for channels in _RGB:
        if set(channels) <= set(table.dtype.names):
            return points, np.stack([_to_byte(table[channel]) for channel in channels], axis=1)
    return points, None


def _to_byte(channel: np.ndarray) -> np.ndarray:
    """A colour channel as uint8; floats run from 0 to 1, integers over their whole type."""
    if channel.dtype.kind == "f":
        return np.round(np.clip(np.nan_to_num(channel), 0, 1) * 255).astype(np.uint8)
    return (channel // (np.iinfo(channel.dtype).max // 255)).astype(np.uint8) if channel.itemsize > 1 else channel


READERS = {
    ".ply": _read_ply,
    ".pcd": _read_pcd,
    ".xyz": _read_text,
    ".csv": _read_text,
    ".npy": _read_npy,
}
