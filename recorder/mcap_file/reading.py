""".mcap -> Session: by the index of an intact file, by a search through a damaged one."""

import mmap
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import UnreadableRecording
from orbitscan.recorder.mcap_file.index import read_index, read_summary
from orbitscan.recorder.mcap_file.messages import ENCODING, POINTS_TOPIC, decode_cloud
from orbitscan.recorder.mcap_file.metadata import describe
from orbitscan.recorder.mcap_file.records import DAMAGE, MAGIC, Contents, read_message
from orbitscan.recorder.mcap_file.recovery import search
from orbitscan.recorder.session import Session, View

_REMEDY = "make a recording with 'orbitscan convert'"


def read(path: str | Path) -> Session:
    """The session of a recording; views are read from the file when asked for, with their CRC checked.

    A view that is lost comes with `damage` and no points. Raises UnreadableRecording where nothing can be read, and
    InvalidPose, from `truth()`, for a recorded pose that is no rotation.
    """
    path = Path(path)
    if not path.is_file():
        problem = "is a folder" if path.is_dir() else "no such file"
        raise UnreadableRecording(path, problem, "name a recording (.mcap)")
    try:
        if path.stat().st_size == 0:
            raise UnreadableRecording(path, "the file is empty", _REMEDY)
        with _open(path) as data:
            if MAGIC not in (data[: len(MAGIC)], data[-len(MAGIC) :]):
                raise UnreadableRecording(path, "not an MCAP file", _REMEDY)
            summary = read_summary(data)
            contents = (summary and read_index(data, summary)) or search(data, summary)
    except OSError as error:
        raise UnreadableRecording(path, f"cannot be read ({error.strerror})", "check its permissions") from None
    _require_clouds(path, contents)
    info, names = describe(path, contents.metadata, {*contents.clouds, *(contents.poses if contents.numbered else ())})
    return Session(
        info=info,
        names=names,
        load=partial(_load_view, path, contents, names),
        load_truth=dict if info.has_estimates else partial(_load_truth, path, contents, len(names)),
        damage=contents.damage,
    )


@contextmanager
def _open(path: Path) -> Iterator[mmap.mmap]:
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        yield data


def _require_clouds(path: Path, contents: Contents) -> None:
    """Raise UnreadableRecording where there is no cloud that we could read."""
    encoding = contents.encodings.get(POINTS_TOPIC, ENCODING)
    if encoding != ENCODING:
        problem = f"its {POINTS_TOPIC} is encoded as '{encoding}', not as a Foxglove PointCloud in {ENCODING}"
    elif contents.clouds:
        return
    elif contents.damage and (contents.metadata or POINTS_TOPIC in contents.encodings):
        problem = f"no view can be read ({contents.damage})"
    elif POINTS_TOPIC in contents.encodings:
        problem = f"nothing was recorded on {POINTS_TOPIC}"
    else:
        topics = ", ".join(sorted(contents.encodings)) or "none that can be read"
        problem = f"holds no {POINTS_TOPIC} (topics: {topics})"
    raise UnreadableRecording(path, problem, _REMEDY)


def _load_view(path: Path, contents: Contents, names: tuple[str, ...], index: int) -> View:
    damage = "missing from the recording"
    if index in contents.clouds:
        try:
            with _open(path) as data:
                message = read_message(data, contents.clouds[index], contents.ours)
            if contents.numbered and message.sequence != index:
                raise ValueError("another view in its place")
            return decode_cloud(message, index, names[index])
        except DAMAGE as error:
            damage = f"damaged in the recording ({type(error).__name__})"
    return View(index, names[index], (index + 1) * 10**9, np.empty((0, 3), np.float32), None, damage)


def _load_truth(path: Path, contents: Contents, views: int) -> dict[int, np.ndarray]:
    truth = {}
    with _open(path) as data:
        for view, place in contents.poses.items():
            try:
                message = read_message(data, place, contents.ours)
                transform = FrameTransform.FromString(message.data)
            except DAMAGE:
                continue  # a lost pose is an unknown one
            t, q = transform.translation, transform.rotation
            index = message.sequence if contents.numbered else view
            if index >= views:
                continue
            truth[index] = poses.from_quaternion(
                np.array([t.x, t.y, t.z]), np.array([q.x, q.y, q.z, q.w]), f"{path.name}, pose of view {index}"
            )
    return truth
