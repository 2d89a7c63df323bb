"""A Rerun recording that appears whole or not at all, the same from the same content."""

import errno
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.review.entities import APPLICATION_ID
from orbitscan.recorder.atomic import whole_file

_SPARE = 1 << 20  # bytes of a disk that are left free


@contextmanager
def whole_recording(
    path: Path, name: str, blueprint: rrb.Blueprint, size: int = 1 << 20
) -> Iterator[rr.RecordingStream]:
    """The stream of a recording, of so many bytes at most, that is at `path` when the block ends.

    Raises UnwritableOutput.
    """
    with whole_file(path) as part:
        reserve(path.parent, size)
        with open_stream(f"{APPLICATION_ID}-{name}") as stream:
            stream.save(part, default_blueprint=blueprint)
            stream.send_recording_name(name)
            yield stream


def open_stream(recording_id: str) -> rr.RecordingStream:
    """A stream without a sink, in which nothing tells when it was written.

    Its application has its name too: a viewer shows all recordings of one application with one layout and one eye.
    """
    identity = _slug(recording_id)
    stream = rr.RecordingStream(
        identity,
        recording_id=identity,
        send_properties=False,  # they hold the time of writing
        batcher_config=rr.ChunkBatcherConfig.NEVER(),  # flushed by us only: the same chunks in every run
    )
    stream.set_log_time_enabled(False)
    return stream


def _slug(name: str) -> str:
    """A name in letters, digits, - and _ alone, as viewers and catalogs want identities; another for another name."""
    slug = re.sub(r"[^A-Za-z0-9_-]+", "-", name)
    return slug if slug == name else f"{slug.strip('-')}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def reserve(folder: Path, size: int) -> None:
    """Raises OSError where a folder's disk has no room for so many bytes: on a full one rerun may wait for ever."""
    if shutil.disk_usage(folder).free < size + _SPARE:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
