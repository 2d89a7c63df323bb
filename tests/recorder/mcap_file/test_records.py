"""Absurd lengths and sizes are damage, and take neither memory nor time."""

import mmap
import struct
import tracemalloc
import zlib

import lz4.frame
import pytest
import zstandard

from orbitscan.recorder import mcap_file
from orbitscan.recorder.mcap_file.records import DAMAGE, LARGEST_CHUNK, read_chunk, read_chunk_head
from tests.recorder.mcap_file.session import make_session

TERABYTE = 2**40
MEGABYTE = 2**20


def chunk(packed, size, crc=0, compression=b"zstd", length=None):
    """A chunk's record."""
    length = len(packed) if length is None else length
    content = (
        struct.pack("<QQQII", 1, 2, size, crc, len(compression)) + compression + struct.pack("<Q", length) + packed
    )
    return struct.pack("<BQ", 6, len(content)) + content


def read(tmp_path, record):
    """The records in a chunk and the memory [bytes] that reading it took at most."""
    path = tmp_path / "chunk"
    path.write_bytes(record)
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        tracemalloc.start()
        try:
            return read_chunk(data, read_chunk_head(data, 0), crc_needed=False)
        finally:
            peak = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
            assert peak < 40 * MEGABYTE


def frame(size):
    """A frame of zstd that tells so large a content, and holds none."""
    return struct.pack("<IBQ", 0xFD2FB528, 0b11100000, size) + b"\x01\x00\x00"


@pytest.mark.parametrize("compression", [b"zstd", b"lz4", b""])
def test_a_whole_chunk_is_read(tmp_path, compression):
    record = struct.pack("<BQ", 5, 22 + 3) + struct.pack("<HIQQ", 7, 8, 9, 10) + b"abc"
    pack = {b"zstd": zstandard.compress, b"lz4": lz4.frame.compress, b"": bytes}[compression]
    (message,) = read(tmp_path, chunk(pack(record), len(record), zlib.crc32(record), compression))
    assert (message.channel_id, message.sequence, message.log_time, message.data) == (7, 8, 9, b"abc")
    with pytest.raises(DAMAGE, match="CRC"):
        read(tmp_path, chunk(pack(record), len(record), zlib.crc32(record) ^ 1, compression))
    with pytest.raises(DAMAGE):
        read(tmp_path, chunk(pack(record), len(record) - 1, 0, compression))


@pytest.mark.parametrize(
    "record",
    [
        chunk(frame(TERABYTE), TERABYTE),
        chunk(frame(TERABYTE), 100),
        chunk(zstandard.compress(b"x" * 100), TERABYTE),
        chunk(zstandard.compress(b"x" * 100 * MEGABYTE), 100),
        chunk(lz4.frame.compress(b"x" * 100 * MEGABYTE), 100, compression=b"lz4"),
        chunk(lz4.frame.compress(b"x" * 100), LARGEST_CHUNK + 1, compression=b"lz4"),
        chunk(b"x" * 100, 100, length=TERABYTE),
        chunk(b"x" * 100, 100, length=2**64 - 1),
        chunk(b"x" * 100, 100, compression=b"snappy"),
        chunk(b"x" * 100, 100, compression=b"zstd" * 1000),
        chunk(b"x" * 100, 100)[:40],
    ],
)
def test_absurd_sizes_are_damage_and_take_no_memory(tmp_path, record):
    with pytest.raises(DAMAGE):
        read(tmp_path, record)


@pytest.mark.parametrize("position", [9 + 16, 9 + 28 + 4, 49 + 5])
def test_absurd_sizes_in_a_recording_cost_their_view(recording, position):
    content = bytearray(recording.read_bytes())
    start = content.index(b"\x04\x00\x00\x00zstd") - 37
    content[start + position : start + position + 8] = struct.pack("<Q", TERABYTE)
    recording.write_bytes(content)
    tracemalloc.start()
    found = mcap_file.read(recording)
    damage = [view.damage for view in found.views()]
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10 * MEGABYTE
    assert damage == [None] * 6
    assert set(found.truth()) == set(make_session().truth()) - {0}
