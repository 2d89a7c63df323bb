"""The contents of an .mcap that is cut, damaged or not of our layout: the chunks that are still whole."""

import mmap
import re
from collections.abc import Mapping
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata
from mcap.stream_reader import breakup_chunk

from recorder.mcap_file.messages import POINTS_TOPIC, POSES_TOPIC
from recorder.mcap_file.records import CHUNK, DAMAGE, MAGIC, METADATA, RECORD_HEADER, Contents, read_content

# How the records we look for start, after their header: a chunk's compression field, our metadata's names.
_CHUNK_SIGNATURE = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")
_BEFORE_CHUNK_SIGNATURE = RECORD_HEADER.size + 28
_METADATA_SIGNATURE = re.compile(rb"\x0c\x00\x00\x00scan_session|\x0a\x00\x00\x00scan_views")


def search(path: Path) -> Contents:
    """The contents of a file that is cut, damaged or not of our layout: every chunk that is still whole is used."""
    topics: dict[int, str] = {}
    metadata: dict[str, Mapping[str, str]] = {}
    messages: list[tuple[int, int, int]] = []  # channel, sequence, offset of the chunk
    broken = 0
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        complete = data[-len(MAGIC) :] == MAGIC and len(data) > 2 * len(MAGIC)
        for offset, opcode in _records(data).items():
            try:
                content = read_content(data, offset, opcode)
                if isinstance(content, Metadata):
                    metadata.setdefault(content.name, content.metadata)
                    continue
                for record in breakup_chunk(content, validate_crc=True):
                    if isinstance(record, Channel):
                        topics[record.id] = record.topic
                    elif isinstance(record, Message):
                        messages.append((record.channel_id, record.sequence, offset))
            except DAMAGE:
                broken += 1
    topics = _summary_topics(path) | topics  # the chunk that declares a channel may be a lost one
    clouds = _by_sequence(messages, topics, POINTS_TOPIC, "scan_session" in metadata)
    poses_ = _by_sequence(messages, topics, POSES_TOPIC, "scan_session" in metadata)
    damage = None
    if not complete:
        damage = "the file is cut or damaged at its end"
    elif broken:
        damage = "parts of the file are damaged"
    return Contents(set(topics.values()), metadata, clouds, poses_, damage)


def _records(data: mmap.mmap) -> dict[int, int]:
    """Offset -> opcode of the chunk and metadata records: by the file's framing as far as it goes, and by their look.

    A damaged length breaks the framing or, worse, steps over whole records; the look finds those.
    """
    found = {}
    offset = len(MAGIC)
    while offset + RECORD_HEADER.size <= len(data):
        opcode, length = RECORD_HEADER.unpack_from(data, offset)
        if not 0x01 <= opcode <= 0x0F or offset + RECORD_HEADER.size + length > len(data):
            break
        if opcode in (CHUNK, METADATA):
            found[offset] = opcode
        offset += RECORD_HEADER.size + length
    for match in _CHUNK_SIGNATURE.finditer(data):
        found[match.start() - _BEFORE_CHUNK_SIGNATURE] = CHUNK
    for match in _METADATA_SIGNATURE.finditer(data):
        if data[match.start() - RECORD_HEADER.size] == METADATA:
            found[match.start() - RECORD_HEADER.size] = METADATA
    return dict(sorted(found.items()))


def _summary_topics(path: Path) -> dict[int, str]:
    """Channel -> topic by the summary, where there is one."""
    try:
        with path.open("rb") as stream:
            summary = make_reader(stream).get_summary()
            return {channel.id: channel.topic for channel in summary.channels.values()} if summary else {}
    except DAMAGE:
        return {}


def _by_sequence(
    messages: list[tuple[int, int, int]], topics: Mapping[int, str], topic: str, ours: bool
) -> dict[int, int]:
    """View -> chunk offset of a topic's messages; by order where somebody else's writer left the sequence at zero."""
    found = [(sequence, offset) for channel, sequence, offset in messages if topics.get(channel) == topic]
    if not ours and len({sequence for sequence, _ in found}) < len(found):
        return {i: offset for i, (_, offset) in enumerate(found)}
    return dict(sorted(dict(reversed(found)).items()))  # the first of a number wins
