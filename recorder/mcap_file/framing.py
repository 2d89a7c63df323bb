"""How far the lengths of a file's records lead, from its start to its end."""

import mmap
import zlib
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from orbitscan.recorder.mcap_file.index import FOOTER_OPCODE, Summary, fits, says_no_summary
from orbitscan.recorder.mcap_file.records import ATTACHMENT, CHANNEL, CHUNK, MAGIC, METADATA, RECORD_HEADER


@dataclass(frozen=True)
class Framing:
    """Where records begin; `whole` where their lengths lead to the end, and the summary names the same chunks."""

    chunks: tuple[int, ...]
    metadata: tuple[int, ...]
    channels: tuple[int, ...]
    attachments: tuple[tuple[int, int], ...]  # start and end of the whole ones, in which nothing is ours
    whole: bool


def lies_in(offset: int, stretches: Sequence[tuple[int, int]]) -> bool:
    """Whether a place lies in one of some stretches: start and end, in order, apart."""
    i = bisect_right(stretches, offset, key=lambda stretch: stretch[0]) - 1
    return i >= 0 and offset < stretches[i][1]


def walk(data: mmap.mmap, summary: Summary | None) -> Framing:
    """The records from the start of a file on, as far as one follows the other."""
    found: dict[int, list[int]] = {CHUNK: [], METADATA: [], CHANNEL: []}
    attachments = []
    offset, opcode = len(MAGIC), 0
    while offset + RECORD_HEADER.size <= len(data) and opcode != FOOTER_OPCODE:
        opcode, length = RECORD_HEADER.unpack_from(data, offset)
        start, end = offset + RECORD_HEADER.size, offset + RECORD_HEADER.size + length
        if opcode == 0 or end > len(data):
            break
        if opcode in found:
            found[opcode].append(offset)
        elif opcode == ATTACHMENT and length > 4 and _crc_is_right(data, start, end):
            attachments.append((offset, end))
        offset = end
    complete = opcode == FOOTER_OPCODE and data[offset:] == MAGIC == data[: len(MAGIC)]
    if summary is None:
        told = complete and says_no_summary(data)
    else:
        told = [chunk.chunk_start_offset for chunk in summary.chunks] == found[CHUNK] and fits(data, summary)
    return Framing(
        chunks=tuple(found[CHUNK]),
        metadata=tuple(found[METADATA]),
        channels=tuple(found[CHANNEL]),
        attachments=tuple(attachments),
        whole=complete and told,
    )


def _crc_is_right(data: mmap.mmap, start: int, end: int) -> bool:
    """Whether an attachment's content, between these, ends with its CRC; 0 is none."""
    told = int.from_bytes(data[end - 4 : end], "little")
    return told == 0 or zlib.crc32(data[start : end - 4]) == told
