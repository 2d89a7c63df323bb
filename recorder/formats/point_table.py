"""The points of a cloud file as a table of named fields: written as text or bytes, split into points and colours."""

import os
from collections.abc import Iterable
from itertools import chain, islice
from typing import IO, AnyStr

import numpy as np

RGB_FIELDS = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))
PACKED_RGB_FIELDS = ("rgb", "rgba")  # 0x00RRGGBB in four bytes, as PCL packs them


def field_names(layout: np.dtype) -> tuple[str, ...]:
    """The names of a layout's fields; none where it has no fields."""
    return layout.names or ()


def read_lines(lines: Iterable[bytes], layout: np.dtype, count: int) -> np.ndarray:
    """Up to `count` records written as text, a line each; columns beyond the layout are left out."""
    names = field_names(layout)
    numbers = read_numbers(islice(lines, count), list(range(len(names))))
    table = np.zeros(len(numbers), layout)
    with np.errstate(invalid="ignore"):  # a NaN among whole numbers
        for i, name in enumerate(names):
            table[name] = numbers[:, i].astype(layout[name])
    return table


def read_numbers(lines: Iterable[AnyStr], columns: list[int], separator: str | None = None) -> np.ndarray:
    """The numbers (N, C) in these columns of lines of text; blank lines are left out. Raises ValueError."""
    filled = (line for line in lines if line.strip())
    first = next(filled, None)
    if first is None:
        return np.empty((0, len(columns)))
    return np.loadtxt(chain([first], filled), comments=None, delimiter=separator, usecols=columns, ndmin=2)


def read_bytes(stream: IO[bytes], layout: np.dtype, count: int) -> np.ndarray:
    """A table of the next `count` records of a stream, or of as many whole ones as are left."""
    size = os.fstat(stream.fileno()).st_size  # a damaged count may be larger than any memory
    data = stream.read(min(count * layout.itemsize, size))
    return np.frombuffer(data, layout, len(data) // layout.itemsize)


def split_fields(table: np.ndarray, declared: int) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) and colours (N, 3) uint8 among the fields of a table that should have so many rows.

    Raises ValueError for a table that is cut, or has no x y z.
    """
    if len(table) < declared:
        raise ValueError(f"it is cut: {len(table):,} of the {declared:,} points it declares")
    names = field_names(table.dtype)
    if not {"x", "y", "z"} <= set(names):
        raise ValueError(f"no x y z among its fields {' '.join(names)}")
    points = np.stack([table[axis] for axis in "xyz"], axis=1)
    for packed in PACKED_RGB_FIELDS:
        if packed in names and table.dtype[packed].itemsize == 4:
            bits = np.ascontiguousarray(table[packed]).view(np.uint32)
            return points, np.stack([(bits >> shift & 255).astype(np.uint8) for shift in (16, 8, 0)], axis=1)
    for channels in RGB_FIELDS:
        if set(channels) <= set(names):
            return points, np.stack([_to_byte(table[channel]) for channel in channels], axis=1)
    return points, None


def _to_byte(channel: np.ndarray) -> np.ndarray:
    """A colour channel as uint8; floats run from 0 to 1, integers over their whole type."""
    if channel.dtype.kind == "f":
        return np.round(np.clip(np.nan_to_num(channel), 0, 1) * 255).astype(np.uint8)
    return (channel // (np.iinfo(channel.dtype).max // 255)).astype(np.uint8) if channel.itemsize > 1 else channel


def split_columns(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """The points (N, 3) and colours (N, 3) uint8 in columns without names.

    The fourth to sixth are colours where they hold whole numbers from 0 to 255, not all below 2; else they are normals.
    """
    points, rest = columns[:, :3], columns[:, 3:6]
    if rest.shape != points.shape or not ((rest >= 0) & (rest <= 255) & (rest % 1 == 0)).all():
        return points, None
    return points, rest.astype(np.uint8) if rest.max(initial=0) > 1 else None
