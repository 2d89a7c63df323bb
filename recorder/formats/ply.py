"""PLY files <-> points and colours."""

from itertools import islice
from pathlib import Path
from typing import IO

import numpy as np

from orbitscan.recorder.formats.point_table import RGB_FIELDS, read_bytes, read_lines, split_fields

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float": "f4", "double": "f8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}

_Element = tuple[str, int, list[tuple[str, str | None]]]  # name, count, fields with their type; None for a list


def read(path: Path) -> tuple[np.ndarray, np.ndarray | None]:
    """The vertices of a PLY file: points (N, 3) and colours (N, 3) uint8. Raises OSError and ValueError."""
    with path.open("rb") as stream:
        if stream.readline(80).strip() != b"ply":
            raise ValueError("it does not start with 'ply'")
        order, elements = _read_header(stream)
        for name, count, fields in elements:
            numbers = [(field, order + kind) for field, kind in fields if kind is not None]
            layout = np.dtype(numbers) if len(numbers) == len(fields) else None  # a list has no fixed length
            if name == "vertex":
                if layout is None:
                    raise ValueError("its vertices hold lists")
                table = read_lines(stream, layout, count) if order == "=" else read_bytes(stream, layout, count)
                return split_fields(table, count)
            if order == "=":
                next(islice(stream, count, count), None)  # skips the lines
            elif layout is None:
                raise ValueError(f"the lists of its element '{name}' stand before its vertices")
            else:
                stream.seek(count * layout.itemsize, 1)
    raise ValueError("it declares no vertices")


def write(
    path: Path, points: np.ndarray, colors: np.ndarray | None = None, triangles: np.ndarray | None = None
) -> None:
    """Write points (N, 3) as float32, with colours (N, 3) uint8 and triangles (T, 3) where given; binary."""
    table = np.empty(len(points), [("points", "<f4", 3), ("colors", "u1", 0 if colors is None else 3)])
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(points)}"]
    header += [f"property float {axis}" for axis in "xyz"]
    table["points"] = points
    if colors is not None:
        header += [f"property uchar {channel}" for channel in RGB_FIELDS[0]]
        table["colors"] = colors
    faces = b""
    if triangles is not None:
        header += [f"element face {len(triangles)}", "property list uchar int vertex_indices"]
        rows = np.empty(len(triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
        rows["count"], rows["corners"] = 3, triangles
        faces = rows.tobytes()
    path.write_bytes("\n".join([*header, "end_header", ""]).encode("ascii") + table.tobytes() + faces)


def _read_header(stream: IO[bytes]) -> tuple[str, list[_Element]]:
    """The byte order ('=' for text) and the elements: name, count, fields with their type (None for a list)."""
    order = ""
    elements: list[_Element] = []
    for line in iter(lambda: stream.readline(4096), b""):
        match line.decode("ascii", "replace").split():
            case ["format", kind, *_] if kind in _ORDERS:
                order = _ORDERS[kind]
            case ["element", name, count]:
                elements.append((name, int(count), []))
            case ["property", "list", _, _, name] if elements:
                elements[-1][2].append((name, None))
            case ["property", kind, name] if elements and kind in _TYPES:
                elements[-1][2].append((name, _TYPES[kind]))
            case ["end_header"] if order:
                return order, elements
            case [] | ["comment" | "obj_info", *_]:
                pass
            case _:
                raise ValueError(f"its header holds '{line[:40].decode('ascii', 'replace').strip()}'")
    raise ValueError("its header is cut")
