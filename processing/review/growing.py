"""A Rerun recording that grows on the disk view by view, and in an open viewer at the same time."""

import errno
import os
import shutil
import socket
from pathlib import Path
from urllib.parse import urlsplit

import rerun as rr

from processing.review.recording import open_stream

VIEWER = "rerun+http://127.0.0.1:9876/proxy"  # where `rerun` listens
_ANSWER_S = 0.3  # for a viewer to take a connection
_SPARE = 1 << 20  # bytes of a disk that are left free


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
        if shutil.disk_usage(self._path.parent).free < size + _SPARE:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def flush(self) -> None:
        """Everything logged is in the file when this returns. Raises OSError."""
        try:
            self.stream.flush()
        except RuntimeError as error:
            if not (self._is_live and "gRPC" in str(error)):
                raise OSError(errno.EIO, str(error)) from error

    def close(self) -> None:
        """Completes the file."""
        self.stream.disconnect()


def is_open(viewer: str) -> bool:
    """Whether something listens at a viewer's address."""
    place = urlsplit(viewer)
    try:
        with socket.create_connection((place.hostname, place.port), timeout=_ANSWER_S):
            return True
    except (OSError, ValueError, TypeError):  # no such host, no port in it
        return False
