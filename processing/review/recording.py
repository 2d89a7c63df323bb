"""A Rerun recording that appears whole or not at all, the same bytes from the same content."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from processing.results.whole import whole_file
from processing.review.entities import APPLICATION_ID


@contextmanager
def whole_recording(path: Path, name: str, blueprint: rrb.Blueprint) -> Iterator[rr.RecordingStream]:
    """The stream of a recording that is at `path` when the block ends. Raises UnwritableOutput."""
    with whole_file(path) as part, open_stream(f"{APPLICATION_ID}-{name}") as stream:
        stream.save(part, default_blueprint=blueprint)
        stream.send_recording_name(name)
        yield stream


def open_stream(recording_id: str) -> rr.RecordingStream:
    """A stream without a sink, in which nothing tells when it was written."""
    stream = rr.RecordingStream(
        APPLICATION_ID,
        recording_id=recording_id,
        send_properties=False,  # they hold the time of writing
        batcher_config=rr.ChunkBatcherConfig.NEVER(),  # flushed by us only: the same chunks in every run
    )
    stream.set_log_time_enabled(False)
    return stream
