"""Whether a recording's writer is still at work: a foreign one writes X.mcap in place, and the footer comes last."""

import glob
import os
import sys
import time
from pathlib import Path
from typing import IO

from orbitscan.recorder.mcap_file.index import FOOTER, FOOTER_LENGTH, FOOTER_OPCODE
from orbitscan.recorder.mcap_file.records import MAGIC, RECORD_HEADER

QUIET_S = 10.0  # an unfinished file that has not changed for so long has no writer any more


def still_being_written(path: Path, quiet_s: float = QUIET_S) -> bool:
    """Whether a file begins as an .mcap, has no end, and is held open for writing or changed within `quiet_s` seconds.

    A finished file costs one look at its last bytes; nothing waits. What cannot be told: Linux alone shows who has a
    file open, and only the processes that this user may look at, on this machine. Elsewhere a writer that is silent for
    longer than `quiet_s` (it may collect megabytes before it writes a chunk; Windows may date a file when it is closed;
    the clock of a network share may be late) looks like one that died. And a file cut for good, but copied or cut a
    moment ago, looks like one still written until it has been quiet for so long.
    """
    try:
        with Path(path).open("rb") as stream:
            if not MAGIC.startswith(stream.read(len(MAGIC))) or _is_complete(stream):
                return False
            status = os.fstat(stream.fileno())
    except OSError:  # gone, or not ours to read: not a question of time
        return False
    return abs(time.time() - status.st_mtime) < quiet_s or _is_open_for_writing(status)


def _is_complete(stream: IO[bytes]) -> bool:
    """Whether a file ends as an .mcap: a footer and the magic."""
    size, end = stream.seek(0, os.SEEK_END), FOOTER.size + len(MAGIC)
    stream.seek(max(0, size - end))
    tail = stream.read(end)
    footer = RECORD_HEADER.pack(FOOTER_OPCODE, FOOTER_LENGTH)
    return len(tail) == end and tail.endswith(MAGIC) and tail.startswith(footer)


def _is_open_for_writing(status: os.stat_result) -> bool:
    """Whether a process that we may look at has the file open for writing; False where /proc does not tell."""
    if sys.platform != "linux":
        return False
    for link in glob.iglob("/proc/[0-9]*/fd/*"):  # of other users' processes it finds none
        try:
            opened = os.stat(link)
            if (opened.st_dev, opened.st_ino) != (status.st_dev, status.st_ino):
                continue
            flags = Path(link.replace("/fd/", "/fdinfo/")).read_text().split("flags:")[1].split()[0]
        except (OSError, IndexError):  # closed meanwhile
            continue
        if int(flags, 8) & os.O_ACCMODE != os.O_RDONLY:
            return True
    return False
