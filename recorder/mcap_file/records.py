"""The records of an .mcap that a session is made of: where they are, and what they hold."""

import mmap
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zstandard
from google.protobuf.message import DecodeError
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Chunk, Message, Metadata
from mcap.stream_reader import breakup_chunk

MAGIC = b"\x89MCAP0\r\n"
CHUNK, METADATA = 0x06, 0x0C
RECORD_HEADER = struct.Struct("<BQ")  # opcode, length


# Everything the libraries raise on rubbish; they share no base.
DAMAGE = (
    McapError,  # bad magic, end of file, absurd lengths
    ValueError,  # CRC mismatch, invalid UTF-8, array sizes
    struct.error,
    zstandard.ZstdError,
    DecodeError,
    RuntimeError,  # lz4
    KeyError,
    MemoryError,  # an absurd length
    OverflowError,
    OSError,  # a position before the start of the file
)


@dataclass(frozen=True)
class Contents:
    """Where in a file the messages are; `damage` says what is lost of it as a whole."""

    topics: set[str]
    metadata: Mapping[str, Mapping[str, str]]
    clouds: Mapping[int, int]  # view -> offset of its chunk
    poses: Mapping[int, int]  # view, or any distinct number -> offset of its chunk
    damage: str | None


def read_content(data: mmap.mmap, offset: int, opcode: int) -> Any:
    """The chunk or metadata record at an offset, by its inner lengths, whatever its outer length says."""
    kind = Chunk if opcode == CHUNK else Metadata
    return kind.read(ReadDataStream(_Window(data, offset + RECORD_HEADER.size)))


class _Window:
    """The part of a buffer that mcap's records are read from, without copying the rest."""

    def __init__(self, data: mmap.mmap, position: int) -> None:
        self.data, self.position = data, position

    def read(self, length: int) -> bytes:
        if length > len(self.data) - self.position:
            raise ValueError("a length beyond the end of the file")
        self.position += length
        return self.data[self.position - length : self.position]


def read_message(path: Path, offset: int, index: int | None) -> Message:
    """The message in the chunk at an offset (of view `index`, where given), its CRC checked."""
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        records = breakup_chunk(read_content(data, offset, CHUNK), validate_crc=True)
    found = [record for record in records if isinstance(record, Message)]
    if index is not None and len(found) > 1:
        found = [record for record in found if record.sequence == index]
    if not found:
        raise ValueError("no message in its chunk")
    return found[0]
