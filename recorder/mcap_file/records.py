"""The records of an .mcap that a session is made of, read without trusting a length or a size."""

import mmap
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import IO, cast

import lz4.frame
import zstandard
from google.protobuf.message import DecodeError
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata
from mcap.stream_reader import breakup_chunk

MAGIC = b"\x89MCAP0\r\n"
CHANNEL, CHUNK, ATTACHMENT, METADATA = 0x04, 0x06, 0x09, 0x0C
RECORD_HEADER = struct.Struct("<BQ")  # opcode, length
LARGEST_CHUNK = 2**30  # bytes uncompressed; a view of 60 million points

_CHUNK_HEAD = struct.Struct("<BQQQQII")  # opcode, length, first and last time, size, its CRC, length of compression
_LENGTH = struct.Struct("<Q")
_FRAME_HEAD = 18  # bytes at most, of a frame of zstd

# Everything the libraries raise on rubbish; they share no base.
DAMAGE = (
    McapError,  # bad magic, end of file, absurd lengths
    ValueError,  # CRC mismatch, invalid UTF-8, array sizes
    TypeError,  # a layout of points that is none
    struct.error,
    zstandard.ZstdError,
    DecodeError,
    RuntimeError,  # lz4
    KeyError,
    MemoryError,  # an absurd length
    OverflowError,
    OSError,  # a position before the start of the file
)


class Implausible(ValueError):
    """A chunk whose head alone shows that it is none."""


@dataclass(frozen=True)
class Place:
    """Where a message is: the chunk at an offset, and which of its messages, counted from 0."""

    offset: int
    nth: int = 0


@dataclass(frozen=True)
class Contents:
    """Where in a file the messages are; `damage` says what is lost of it as a whole."""

    encodings: Mapping[str, str]  # topic -> encoding of its messages
    metadata: Mapping[str, Mapping[str, str]]  # that can be believed
    clouds: Mapping[int, Place]  # by view
    poses: Mapping[int, Place]  # by view or, where messages are numbered, in any order
    numbered: bool  # whether a message's sequence is its view
    ours: bool  # whether our writer wrote it, which always tells a CRC
    damage: str | None = None


@dataclass(frozen=True)
class ChunkHead:
    """The fields of a chunk record that stand before its data."""

    offset: int
    record_length: int
    times: tuple[int, int]  # [ns] of its first and last message
    size: int  # of the data, uncompressed
    crc: int
    compression: str
    start: int  # of the data
    length: int

    @property
    def end(self) -> int:
        """Where the data end, whatever the record's own length says."""
        return self.start + self.length


def read_chunk_head(data: mmap.mmap, offset: int) -> ChunkHead:
    """The head of the chunk at an offset. Raises one of DAMAGE where its data would not fit into the file."""
    if offset < 0:
        raise ValueError("before the start of the file")
    _, record_length, *times, size, crc, name_length = _CHUNK_HEAD.unpack_from(data, offset)
    name = offset + _CHUNK_HEAD.size
    if name_length > 8:
        raise ValueError("no compression has so long a name")
    (length,) = _LENGTH.unpack_from(data, name + name_length)
    compression = data[name : name + name_length].decode("ascii")
    head = ChunkHead(offset, record_length, tuple(times), size, crc, compression, name + name_length + 8, length)
    if head.end > len(data):
        raise ValueError("a length beyond the end of the file")
    return head


def read_chunk(data: mmap.mmap, head: ChunkHead, crc_needed: bool) -> list[McapRecord]:
    """The records in a chunk, its CRC checked. Raises one of DAMAGE; never takes more memory than the chunk is long.

    Other writers may leave the CRC out; ours never does.
    """
    if crc_needed and not head.crc:
        raise Implausible("the CRC is lost")
    if head.size > LARGEST_CHUNK:
        raise Implausible("no chunk is so large")
    if head.compression == "zstd":
        told = zstandard.frame_content_size(data[head.start : min(head.end, head.start + _FRAME_HEAD)])
        if told not in (head.size, -1):
            raise Implausible("two sizes")  # and the data's own would be allocated
    content = _decompress(data[head.start : head.end], head)
    if head.crc and zlib.crc32(content) != head.crc:
        raise ValueError("CRC mismatch")
    first, last = head.times
    return breakup_chunk(Chunk("", content, last, first, uncompressed_crc=0, uncompressed_size=len(content)))


def _decompress(packed: bytes, head: ChunkHead) -> bytes:
    """A chunk's data, no more than the size its head tells."""
    if head.compression == "zstd":
        content = zstandard.ZstdDecompressor().decompress(packed, max_output_size=head.size)
    elif head.compression == "lz4":
        decompressor = lz4.frame.LZ4FrameDecompressor()
        content = decompressor.decompress(packed, max_length=head.size)
        if not decompressor.eof:
            raise ValueError("larger than it tells")
    elif head.compression == "":
        content = packed
    else:
        raise ValueError("an unknown compression")
    if len(content) != head.size:
        raise ValueError("not of the size it tells")
    return content


def read_message(data: mmap.mmap, place: Place, crc_needed: bool) -> Message:
    """The message at a place, the CRC of its chunk checked. Raises one of DAMAGE."""
    records = read_chunk(data, read_chunk_head(data, place.offset), crc_needed)
    found = [record for record in records if isinstance(record, Message)]
    if place.nth >= len(found):
        raise ValueError("no message in its chunk")
    return found[place.nth]


def read_metadata(data: mmap.mmap, start: int) -> tuple[Metadata, int]:
    """The metadata whose content starts there, by its inner lengths, and where it ends. Raises one of DAMAGE."""
    window = _Window(data, start)
    return Metadata.read(ReadDataStream(cast(IO[bytes], window))), window.position


def read_channel(data: mmap.mmap, start: int) -> Channel:
    """The channel whose content starts there. Raises one of DAMAGE."""
    return Channel.read(ReadDataStream(cast(IO[bytes], _Window(data, start))))


class _Window:
    """The part of a buffer that mcap's records are read from, without copying the rest."""

    def __init__(self, data: mmap.mmap, position: int) -> None:
        self.data, self.position = data, position

    def read(self, length: int) -> bytes:
        if length > len(self.data) - self.position:
            raise ValueError("a length beyond the end of the file")
        self.position += length
        return self.data[self.position - length : self.position]
