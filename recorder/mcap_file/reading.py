""".mcap -> Session: by the index of an intact file, by a search through a damaged one."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform

from recorder import poses
from recorder.exceptions import UnreadableRecording
from recorder.mcap_file.description import describe
from recorder.mcap_file.index import read_index
from recorder.mcap_file.messages import POINTS_TOPIC, decode_cloud
from recorder.mcap_file.records import DAMAGE, MAGIC, read_message
from recorder.mcap_file.search import search
from recorder.session import Session, View


def read(path: Path) -> Session:
    """The session of a recording; views are read from the file when asked for, with their CRC checked.

    A view that is lost comes with `damage` and no points. Raises UnreadableRecording where nothing can be read, and
    InvalidPose, from `truth()`, for a recorded pose that is no rotation.
    """
    path = Path(path)
    if not path.is_file():
        problem = "is a folder" if path.is_dir() else "no such file"
        raise UnreadableRecording(path, problem, "name a recording (.mcap)")
    try:
        start = path.open("rb").read(len(MAGIC))
    except OSError as error:
        raise UnreadableRecording(path, f"cannot be read ({error.strerror})", "check its permissions") from None
    if start != MAGIC:
        problem = "the file is empty" if not start else "not an MCAP file"
        raise UnreadableRecording(path, problem, "make a recording with 'orbitscan convert'")
    contents = read_index(path) or search(path)
    if POINTS_TOPIC not in contents.topics and not contents.clouds:
        topics = ", ".join(sorted(contents.topics)) or "none that can be read"
        raise UnreadableRecording(
            path, f"holds no {POINTS_TOPIC} (topics: {topics})", "make a recording with 'orbitscan convert'"
        )
    info, names = describe(path, contents.metadata, contents.clouds)
    return Session(
        info=info,
        names=names,
        load=partial(_load_view, path, contents.clouds, names),
        load_truth=partial(_load_truth, path, contents.poses),
        damage=contents.damage,
    )


def _load_view(path: Path, clouds: Mapping[int, int], names: tuple[str, ...], index: int) -> View:
    offset = clouds.get(index)
    damage = "missing from the recording"
    if offset is not None:
        try:
            message = read_message(path, offset, index)
            return decode_cloud(message, index, names[index])
        except DAMAGE as error:
            damage = f"damaged in the recording ({type(error).__name__})"
    return View(index, names[index], (index + 1) * 10**9, np.empty((0, 3), np.float32), None, damage)


def _load_truth(path: Path, chunks: Mapping[int, int]) -> dict[int, np.ndarray]:
    truth = {}
    for key, offset in chunks.items():
        try:
            message = read_message(path, offset, None)
            transform = FrameTransform.FromString(message.data)
        except DAMAGE:
            continue  # a lost pose is an unknown one
        t, q = transform.translation, transform.rotation
        index = message.sequence or key  # somebody else's writer may leave the sequence at zero
        truth[index] = poses.from_quaternion(
            np.array([t.x, t.y, t.z]), np.array([q.x, q.y, q.z, q.w]), f"{path.name}, pose of view {index}"
        )
    return truth
