"""The contents of an .mcap of our layout by its summary."""

import os
import struct
import zlib
from pathlib import Path
from typing import IO

from mcap.reader import make_reader

from recorder.mcap_file.messages import POINTS_TOPIC, POSES_TOPIC
from recorder.mcap_file.records import DAMAGE, MAGIC, Contents

_FOOTER = struct.Struct("<BQQQI")  # opcode, length, start of the summary, of its offsets, CRC of the summary


def read_index(path: Path) -> Contents | None:
    """The contents by the file's summary; None where it has none, or one that does not fit our layout."""
    try:
        with path.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            if summary is None or not summary.chunk_indexes or not _summary_is_whole(stream):
                return None
            metadata = {record.name: record.metadata for record in reader.iter_metadata()}
            ids = {channel.topic: channel.id for channel in summary.channels.values()}
            chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
            clouds = [c.chunk_start_offset for c in chunks if ids.get(POINTS_TOPIC) in c.message_index_offsets]
            pose_chunks = [c.chunk_start_offset for c in chunks if ids.get(POSES_TOPIC) in c.message_index_offsets]
            views = metadata["scan_session"]["views"]
            if len(clouds) != int(views) or summary.statistics is None:
                return None
            if summary.statistics.message_count != len(clouds) + len(pose_chunks):
                return None  # other topics, or several messages a chunk: somebody else's layout
    except DAMAGE:
        return None
    return Contents(set(ids), metadata, dict(enumerate(clouds)), dict(enumerate(pose_chunks)), None)


def _summary_is_whole(stream: IO[bytes]) -> bool:
    """Whether the summary has the CRC its footer tells; the library trusts it, and may take one view for another."""
    stream.seek(-(_FOOTER.size + len(MAGIC)), os.SEEK_END)
    end = stream.tell() + _FOOTER.size - 4  # the CRC itself is left out
    _, _, start, _, crc = _FOOTER.unpack(stream.read(_FOOTER.size))
    stream.seek(start)
    return crc == 0 or zlib.crc32(stream.read(end - start)) == crc
