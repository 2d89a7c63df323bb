"""The contents of an .mcap that is cut, damaged or not of our layout: the chunks that are still whole."""

import mmap
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from mcap.records import Channel, Message, Metadata

from orbitscan.recorder.mcap_file.framing import Framing, lies_in, walk
from orbitscan.recorder.mcap_file.index import Summary
from orbitscan.recorder.mcap_file.messages import ENCODING, POINTS_TOPIC, POSES_TOPIC, look_like
from orbitscan.recorder.mcap_file.metadata import LOST_AT_MOST, SESSION, VIEWS, believe
from orbitscan.recorder.mcap_file.records import (
    DAMAGE,
    MAGIC,
    RECORD_HEADER,
    Contents,
    Implausible,
    Place,
    read_channel,
    read_chunk,
    read_chunk_head,
    read_metadata,
)

# How the records we look for start, after their header: a chunk's compression field, our metadata's names.
_CHUNK_SIGNATURE = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")
_BEFORE_CHUNK_SIGNATURE = RECORD_HEADER.size + 28
_METADATA_SIGNATURE = re.compile(rb"\x0c\x00\x00\x00scan_session|\x0a\x00\x00\x00scan_views")
# How much a search takes that comes to nothing: a file may be made so that each look costs as much as the whole file.
_FAILURES, _WASTE = 10_000, 2**28  # looks; bytes, besides twice the file


def search(data: mmap.mmap, summary: Summary | None) -> Contents:
    """The contents of a file whose summary, where it has one, does not say all; every chunk still whole is used."""
    framing = walk(data, summary)
    found = _Finder(data, {channel.id: channel for channel in summary.channels.values()} if summary else {})
    for offset in framing.channels:
        found.add_channel(offset)
    for offset in framing.metadata:
        found.add_metadata(offset + RECORD_HEADER.size)
    if not framing.whole:
        found.look_for_metadata(framing)
    metadata = believe(found.metadata)
    ours = SESSION in metadata
    for offset in framing.chunks:
        found.add_chunk(offset, ours)
    damaged = bool(found.failures) or not framing.whole
    if damaged:
        found.look_for_chunks(framing, ours)
    clouds, poses, numbered = _number(found, ours, damaged)
    damage = _tell_damage(data, framing, found, metadata)
    return Contents(found.encodings(), metadata, clouds, poses, numbered, ours, damage)


@dataclass(frozen=True)
class _Found:
    """A message in a whole chunk."""

    channel: int
    sequence: int
    digest: tuple[int, int, int]  # tells it from others, not from a copy
    looks_like: str | None  # the topic, where nothing has declared its channel so far
    place: Place


@dataclass
class _Finder:
    """Collects what a search through a damaged file has found so far."""

    data: mmap.mmap
    channels: dict[int, Channel]  # by a record with a CRC
    hearsay: dict[int, Channel] = field(default_factory=dict)  # by one without
    metadata: list[Metadata] = field(default_factory=list)
    messages: list[_Found] = field(default_factory=list)
    whole: list[tuple[int, int]] = field(default_factory=list)  # start and end of chunks
    failures: int = 0
    waste: int = 0

    def add_channel(self, offset: int) -> None:
        if self._is_hopeless():
            return
        try:
            channel = read_channel(self.data, offset + RECORD_HEADER.size)
            self.hearsay.setdefault(channel.id, channel)
        except DAMAGE:
            self.failures += 1

    def add_metadata(self, start: int) -> None:
        if self._is_hopeless():
            return
        try:
            record, end = read_metadata(self.data, start)
        except DAMAGE:
            self.failures += 1
            return
        self.metadata.append(record)
        self.waste += end - start

    def look_for_metadata(self, framing: Framing) -> None:
        """Find our metadata records by the bytes they begin with, where no length leads to them."""
        for match in _METADATA_SIGNATURE.finditer(self.data):
            if not lies_in(match.start(), framing.attachments):
                self.add_metadata(match.start())
            if self._is_hopeless():
                break
        self.failures = self.waste = 0

    def add_chunk(self, offset: int, crc_needed: bool) -> None:
        """Take the messages of the chunk at an offset, if it is whole."""
        if self._is_hopeless():
            return
        size = 0
        try:
            head = read_chunk_head(self.data, offset)
            size = head.length + head.size
            records = read_chunk(self.data, head, crc_needed)
        except DAMAGE as error:
            self.failures += 1
            self.waste += 0 if isinstance(error, Implausible) else size
            return
        self.whole.append((offset, head.end))
        for record in records:
            if isinstance(record, Channel):
                self.channels.setdefault(record.id, record)
        messages = [record for record in records if isinstance(record, Message)]
        for nth, message in enumerate(messages):
            self.messages.append(
                _Found(
                    channel=message.channel_id,
                    sequence=message.sequence,
                    digest=(message.log_time, len(message.data), zlib.crc32(message.data)),
                    looks_like=None if message.channel_id in self.channels else look_like(message.data),
                    place=Place(offset, nth),
                )
            )

    def look_for_chunks(self, framing: Framing, crc_needed: bool) -> None:
        """Chunks by their look, where the framing has found none: a damaged length breaks it, or steps over some."""
        known, tried = sorted([*self.whole, *framing.attachments]), set(framing.chunks)
        end = 0  # of the last one found
        for match in _CHUNK_SIGNATURE.finditer(self.data):
            offset = match.start() - _BEFORE_CHUNK_SIGNATURE
            if offset < end or offset in tried or lies_in(match.start(), known):
                continue
            self.add_chunk(offset, crc_needed)
            if self.whole and self.whole[-1][0] == offset:
                end = self.whole[-1][1]
            if self._is_hopeless():
                return

    def _is_hopeless(self) -> bool:
        return self.failures > _FAILURES or self.waste > _WASTE + 2 * len(self.data)

    def topic(self, message: _Found) -> str | None:
        """A message's topic: by a channel record with a CRC, else by the content, else by a record without CRC."""
        channel, heard = self.channels.get(message.channel), self.hearsay.get(message.channel)
        return channel.topic if channel else message.looks_like or (heard.topic if heard else None)

    def of(self, topic: str) -> Iterator[_Found]:
        """The messages of a topic in the order of the file, copies left out."""
        seen = set()
        for message in sorted(self.messages, key=lambda message: (message.place.offset, message.place.nth)):
            if self.topic(message) == topic and (message.sequence, message.digest) not in seen:
                seen.add((message.sequence, message.digest))
                yield message

    def encodings(self) -> dict[str, str]:
        """Topic -> encoding, which what looks like ours has too."""
        told = {channel.topic: channel.message_encoding for channel in (self.hearsay | self.channels).values()}
        undeclared = (message for message in self.messages if message.channel not in self.channels)
        return told | {message.looks_like: ENCODING for message in undeclared if message.looks_like}


def _number(found: _Finder, ours: bool, damaged: bool) -> tuple[dict[int, Place], dict[int, Place], bool]:
    """The places of clouds and poses by view, and whether a message's number is its view.

    In a whole file of somebody else's writer, numbers may start anywhere or all be zero; there only their order counts.
    """
    clouds, poses = list(found.of(POINTS_TOPIC)), list(found.of(POSES_TOPIC))
    numbers = sorted({cloud.sequence for cloud in clouds})
    distinct = len(numbers) == len(clouds)
    sparse = bool(numbers) and numbers[-1] >= len(numbers) + LOST_AT_MOST
    if (ours or (damaged and distinct)) and not sparse:
        near = [pose for pose in poses if pose.sequence < len(poses) + LOST_AT_MOST]
        return _by_number(clouds), _by_number(near), True
    if distinct:
        views = {number: view for view, number in enumerate(numbers)}
        return _by_number(clouds, views), _by_number(poses, views), False
    in_order = [{i: message.place for i, message in enumerate(kind)} for kind in (clouds, poses)]
    return in_order[0], in_order[1], False


def _by_number(messages: Iterable[_Found], views: Mapping[int, int] | None = None) -> dict[int, Place]:
    """View -> place, the first of a number; by a table from number to view, where there is one."""
    places: dict[int, Place] = {}
    for message in messages:
        view = message.sequence if views is None else views.get(message.sequence)
        if view is not None:
            places.setdefault(view, message.place)
    return dict(sorted(places.items()))


def _tell_damage(
    data: mmap.mmap, framing: Framing, found: _Finder, metadata: Mapping[str, Mapping[str, str]]
) -> str | None:
    if framing.whole and not found.failures and {record.name for record in found.metadata} == set(metadata):
        return None
    if data[-len(MAGIC) :] != MAGIC or len(data) < 2 * len(MAGIC):
        what = "the file is cut or damaged at its end"
    elif data[: len(MAGIC)] != MAGIC:
        what = "the file is damaged at its start"
    else:
        what = "parts of the file are damaged"
    known = {SESSION: "the facts of the session", VIEWS: "the names of the views"}
    lost = [words for name, words in known.items() if name not in metadata]
    return f"{what}; {' and '.join(lost)} are lost" if lost else what
