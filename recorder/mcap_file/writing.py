"""Session -> .mcap: every message a chunk of its own, flushed, so that a writer that dies loses nothing it finished."""

from pathlib import Path
from typing import Any

from mcap.writer import CompressionType
from mcap_protobuf.writer import Writer

from orbitscan.recorder.atomic import whole_file
from orbitscan.recorder.mcap_file.messages import POINTS_TOPIC, POSES_TOPIC, cloud_message, pose_message
from orbitscan.recorder.mcap_file.metadata import SESSION, VIEWS, info_to_metadata, seal
from orbitscan.recorder.session import Session


def write(session: Session, path: Path) -> None:
    """Write a session's views and true poses; the file appears whole or not at all. Raises UnwritableOutput.

    While it grows it is called `<path>.part`, which `read` understands too.
    """
    with whole_file(Path(path), failures=OSError) as part, part.open("wb") as stream:
        _write(session, stream)


def _write(session: Session, stream: Any) -> None:
    writer = Writer(stream, chunk_size=1, compression=CompressionType.ZSTD)
    writer.add_metadata(SESSION, seal(SESSION, info_to_metadata(session.info, len(session.names))))
    writer.add_metadata(VIEWS, seal(VIEWS, {str(i): name for i, name in enumerate(session.names)}))
    truth = session.truth()
    for view in session.views("all"):
        times = {"log_time": view.stamp_ns, "publish_time": view.stamp_ns, "sequence": view.index}
        if (T_object_camera := truth.get(view.index)) is not None:
            writer.write_message(POSES_TOPIC, pose_message(view.stamp_ns, T_object_camera), **times)
        writer.write_message(POINTS_TOPIC, cloud_message(view), **times)
        stream.flush()
    writer.finish()
