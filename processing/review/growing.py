"""A Rerun recording that grows on the disk view by view, and in an open viewer at the same time."""

import errno
import socket
from pathlib import Path
from urllib.parse import urlsplit

import rerun as rr

from orbitscan.processing.review.stream import open_stream, reserve

_ANSWER_S = 0.3  # for a viewer to take a connection


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

    def close(self) -> None:
        """Completes the file."""
        self.stream.disconnect()


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
