"""PCD files of the Point Cloud Library -> points and colours."""

import struct
from pathlib import Path
from typing import IO

import numpy as np

from orbitscan.recorder.formats.point_table import field_names, read_bytes, read_lines, split_fields

_TYPES = {"F": "f", "I": "i", "U": "u"}


def read(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) of a PCD file and their colours (N, 3) uint8. Raises OSError and ValueError."""
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
        layout = _read_layout(header)
        width, height = (int(header.get(key, ["1"])[0]) for key in ("WIDTH", "HEIGHT"))
        count = int(header["POINTS"][0]) if "POINTS" in header else width * height
        match header["DATA"][0]:
            case "ascii":
                table = read_lines(stream, layout, count)
            case "binary":
                table = read_bytes(stream, layout, count)
            case "binary_compressed":
                table = _read_compressed(stream, layout, count)
            case other:
                raise ValueError(f"its data are '{other}'")
    return split_fields(table, count)


def _read_layout(header: dict[str, list[str]]) -> np.dtype:
    """The layout of a point; a field of several numbers gets a column for each."""
    fields = header["FIELDS"]
    counts = header.get("COUNT", ["1"] * len(fields))
    layout = []
    for i, (name, size, kind, count) in enumerate(zip(fields, header["SIZE"], header["TYPE"], counts, strict=True)):
        if kind not in _TYPES:
            raise ValueError(f"its field {name} has the type '{kind}'")
        names = [name if int(count) == 1 and name != "_" else f"{name}.{i}.{k}" for k in range(int(count))]
        layout += [(unique, f"<{_TYPES[kind]}{size}") for unique in names]
    try:
        return np.dtype(layout)
    except TypeError as error:
        raise ValueError(f"its fields make no sense: {error}") from None


def _read_compressed(stream: IO[bytes], layout: np.dtype, count: int) -> np.ndarray:
    """PCL's binary_compressed: LZF over all values of the first field, then all of the second, ..."""
    sizes = stream.read(8)
    if len(sizes) < 8:
        raise ValueError("its compressed data are cut")
    packed_size, size = struct.unpack("<II", sizes)
    if size != count * layout.itemsize:
        raise ValueError(f"{size} bytes for {count} points of {layout.itemsize}")
    data = _decompress_lzf(stream.read(packed_size), size)
    table, start = np.zeros(count, layout), 0
    for name in field_names(layout):
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
