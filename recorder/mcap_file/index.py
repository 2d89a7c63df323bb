"""The contents of an .mcap of our layout by its summary, where the file fits it."""

import mmap
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from io import BytesIO

from mcap.records import Channel, ChunkIndex, MetadataIndex, Statistics
from mcap.stream_reader import StreamReader

from orbitscan.recorder.mcap_file.messages import POINTS_TOPIC, POSES_TOPIC
from orbitscan.recorder.mcap_file.metadata import SESSION, believe
from orbitscan.recorder.mcap_file.records import (
    CHUNK,
    DAMAGE,
    MAGIC,
    RECORD_HEADER,
    Contents,
    Place,
    read_chunk_head,
    read_metadata,
)

FOOTER = struct.Struct("<BQQQI")  # opcode, length, start of the summary, of its offsets, CRC of the summary
FOOTER_OPCODE, FOOTER_LENGTH = 0x02, 20


@dataclass(frozen=True)
class Summary:
    """What the end of a file tells of the rest."""

    channels: Mapping[int, Channel] = field(default_factory=dict)
    chunks: tuple[ChunkIndex, ...] = ()  # in the order of the file
    metadata: tuple[MetadataIndex, ...] = ()
    statistics: Statistics | None = None


def read_summary(data: mmap.mmap) -> Summary | None:
    """A file's summary; None where it has none that has the CRC its footer tells.

    mcap's own reader believes a summary, and with a flipped bit takes one view for another.
    """
    footer = len(data) - FOOTER.size - len(MAGIC)
    if footer < len(MAGIC) or data[-len(MAGIC) :] != MAGIC:
        return None
    opcode, length, start, _, crc = FOOTER.unpack_from(data, footer)
    if (opcode, length) != (FOOTER_OPCODE, FOOTER_LENGTH) or not len(MAGIC) <= start <= footer or not crc:
        return None
    if zlib.crc32(data[start : footer + FOOTER.size - 4]) != crc:  # the CRC itself is left out
        return None
    try:
        records = list(StreamReader(BytesIO(data[start:]), skip_magic=True, emit_chunks=True).records)
    except DAMAGE:
        return None
    chunks = [record for record in records if isinstance(record, ChunkIndex)]
    return Summary(
        channels={record.id: record for record in records if isinstance(record, Channel)},
        chunks=tuple(sorted(chunks, key=lambda chunk: chunk.chunk_start_offset)),
        metadata=tuple(record for record in records if isinstance(record, MetadataIndex)),
        statistics=next((record for record in records if isinstance(record, Statistics)), None),
    )


def says_no_summary(data: mmap.mmap) -> bool:
    """Whether the footer of a complete file says that there is no summary, or that it has no CRC."""
    _, _, start, _, crc = FOOTER.unpack_from(data, len(data) - FOOTER.size - len(MAGIC))
    return start == 0 or crc == 0


def read_index(data: mmap.mmap, summary: Summary) -> Contents | None:
    """The contents by the file's summary; None where the file does not fit it, or is not of our layout."""
    ids = {channel.topic: channel.id for channel in summary.channels.values()}
    clouds = [c.chunk_start_offset for c in summary.chunks if ids.get(POINTS_TOPIC) in c.message_index_offsets]
    poses = [c.chunk_start_offset for c in summary.chunks if ids.get(POSES_TOPIC) in c.message_index_offsets]
    messages = summary.statistics.message_count if summary.statistics else 0
    if data[: len(MAGIC)] != MAGIC or not clouds or messages != len(clouds) + len(poses):
        return None  # damaged, or other topics, or several messages a chunk: somebody else's layout
    if not fits(data, summary):
        return None
    try:
        records = [read_metadata(data, index.offset + RECORD_HEADER.size)[0] for index in summary.metadata]
    except DAMAGE:
        return None
    metadata = believe(records)
    if (
        set(metadata) != {record.name for record in records}
        or metadata.get(SESSION, {}).get("views") != f"{len(clouds)}"
    ):
        return None
    encodings = {channel.topic: channel.message_encoding for channel in summary.channels.values()}
    cloud_places = {i: Place(offset) for i, offset in enumerate(clouds)}
    pose_places = {i: Place(offset) for i, offset in enumerate(poses)}
    return Contents(encodings, metadata, cloud_places, pose_places, numbered=True, ours=True)


def fits(data: mmap.mmap, summary: Summary) -> bool:
    """Whether the chunks that the summary tells of stand in their places, and no others."""
    try:
        return all(_is_at_its_place(data, index) for index in summary.chunks)
    except DAMAGE:
        return False


def _is_at_its_place(data: mmap.mmap, index: ChunkIndex) -> bool:
    head = read_chunk_head(data, index.chunk_start_offset)
    return (
        data[head.offset] == CHUNK
        and head.record_length + RECORD_HEADER.size == index.chunk_length == head.end - head.offset
        and head.times == (index.message_start_time, index.message_end_time)
        and (head.compression, head.length, head.size)
        == (index.compression, index.compressed_size, index.uncompressed_size)
    )
