"""Rerun recordings: one that appears whole or not at all, and one that grows on the disk and in an open viewer."""

import errno
import hashlib
import os
import re
import shutil
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.review.entities import APPLICATION_ID
from orbitscan.recorder.atomic import whole_file

_ANSWER_S = 0.3  # for a viewer to take a connection
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


class GrowingRecording:
    """A stream into a file, readable up to the last `flush` whatever happens then, and to a viewer where one is open.

    A viewer that is not there, or goes away, costs nothing. On a full disk rerun's writer may wait for ever: `reserve`
    asks for the room first.
    """

    def __init__(self, path: Path, recording_id: str, viewer: str | None = None) -> None:
        self.stream = open_stream(recording_id)
        self._path = path
        self._is_live = viewer is not None and is_open(viewer)
        if self._is_live:
            self.stream.set_sinks(rr.GrpcSink(viewer), rr.FileSink(path))
        else:
            self.stream.save(path)

    def reserve(self, size: int) -> None:
        """Raises OSError where the disk has no room for so many bytes."""
        reserve(self._path.parent, size)

    def flush(self) -> None:
        """Everything logged is in the file when this returns. Raises OSError."""
        try:
            self.stream.flush()
        except RuntimeError as error:
            if not (self._is_live and "gRPC" in str(error)):
                raise OSError(errno.EIO, str(error)) from error


def make_document(markdown: str) -> rr.TextDocument:
    """Words that a text view shows as Markdown."""
    return rr.TextDocument(markdown, media_type=rr.MediaType.MARKDOWN)


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


def is_open(viewer: str) -> bool:
    """Whether something listens at a viewer's address."""
    place = urlsplit(viewer)
    try:
        with socket.create_connection((place.hostname, place.port), timeout=_ANSWER_S):
            return True
    except OSError:
        return False


def is_address(text: str) -> bool:
    """Whether a text is the address of a viewer, such as rerun+http://127.0.0.1:9876/proxy."""
    place = urlsplit(text)
    try:
        return bool(place.scheme.startswith("rerun") and place.hostname and place.port)
    except ValueError:  # a port that is no number
        return False
