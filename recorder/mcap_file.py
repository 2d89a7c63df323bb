"""Session <-> .mcap: Foxglove protobuf messages, zstd, that open in Foxglove and Rerun with nothing converted.

Every message is a chunk of its own and is flushed: a writer that dies loses nothing it had finished, a flipped bit
costs one view, poses are read without decompressing clouds. A file with an intact summary is read by its index; a cut
or damaged one is searched for the chunks that are still whole.
"""

import contextlib
import mmap
import os
import re
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np
import zstandard
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from google.protobuf.message import DecodeError
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, Metadata
from mcap.stream_reader import breakup_chunk
from mcap.writer import CompressionType
from mcap_protobuf.writer import Writer

from recorder import poses
from recorder.exceptions import UnreadableRecording, UnwritableOutput
from recorder.session import Session, SessionInfo, View

POINTS_TOPIC = "/camera/points"
POSES_TOPIC = "/tf"
FORMAT_VERSION = "1"

_MAGIC = b"\x89MCAP0\r\n"
_CHUNK_OPCODE, _METADATA_OPCODE = 0x06, 0x0C
_RECORD_HEADER = struct.Struct("<BQ")  # opcode, length
_FOOTER = struct.Struct("<BQQQI")  # opcode, length, start of the summary, of its offsets, CRC of the summary
# How the records we look for start, after their header: a chunk's compression field, our metadata's names.
_CHUNK_SIGNATURE = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")
_BEFORE_CHUNK_SIGNATURE = _RECORD_HEADER.size + 28
_METADATA_SIGNATURE = re.compile(rb"\x0c\x00\x00\x00scan_session|\x0a\x00\x00\x00scan_views")
# Everything the libraries raise on rubbish; they share no base.
_DAMAGE = (
    McapError,  # bad magic, end of file, absurd lengths
    ValueError,  # CRC mismatch, invalid UTF-8, array sizes
    struct.error,
    zstandard.ZstdError,
    DecodeError,
    RuntimeError,  # lz4
    KeyError,
    MemoryError,  # an absurd length
    OverflowError,
    OSError,  # a position before the start of the file
)
_XYZ = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
_RGBA = [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("alpha", "u1")]
_NUMPY_TYPES = {
    PackedElementField.UINT8: "u1", PackedElementField.INT8: "i1",
    PackedElementField.UINT16: "<u2", PackedElementField.INT16: "<i2",
    PackedElementField.UINT32: "<u4", PackedElementField.INT32: "<i4",
    PackedElementField.FLOAT32: "<f4", PackedElementField.FLOAT64: "<f8",
}  # fmt: skip


# --- writing ---------------------------------------------------------------------------------------------------------


def write(session: Session, path: Path) -> None:
    """Write a session's views and true poses; the file appears whole or not at all. Raises UnwritableOutput.

    While it grows it is called `<path>.part`, which `read` understands too.
    """
    path = Path(path)
    part = path.with_name(path.name + ".part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with part.open("wb") as stream:
            _write(session, stream)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(path)
    except OSError as error:
        _discard(part)
        raise UnwritableOutput(path, f"cannot be written ({error.strerror})", "choose another place with -o") from None
    except BaseException:
        _discard(part)
        raise


def _discard(part: Path) -> None:
    with contextlib.suppress(OSError):  # it may stand where nothing can: in a file, in a folder that is read-only
        part.unlink()


def _write(session: Session, stream: Any) -> None:
    writer = Writer(stream, chunk_size=1, compression=CompressionType.ZSTD)
    writer.add_metadata("scan_session", _info_to_metadata(session.info, len(session.names)))
    writer.add_metadata("scan_views", {str(i): name for i, name in enumerate(session.names)})
    truth = session.truth()
    for view in session.views("all"):
        times = {"log_time": view.stamp_ns, "publish_time": view.stamp_ns, "sequence": view.index}
        if (T_object_camera := truth.get(view.index)) is not None:
            writer.write_message(POSES_TOPIC, _pose_message(view.stamp_ns, T_object_camera), **times)
        writer.write_message(POINTS_TOPIC, _cloud_message(view), **times)
        stream.flush()
    writer.finish()


def _pose_message(stamp_ns: int, T_object_camera: np.ndarray) -> FrameTransform:
    message = FrameTransform(parent_frame_id="object", child_frame_id="camera")
    message.timestamp.FromNanoseconds(stamp_ns)
    x, y, z = T_object_camera[:3, 3]
    message.translation.x, message.translation.y, message.translation.z = x, y, z
    qx, qy, qz, qw = poses.to_quaternion(T_object_camera)
    message.rotation.x, message.rotation.y, message.rotation.z, message.rotation.w = qx, qy, qz, qw
    return message


def _cloud_message(view: View) -> PointCloud:
    layout = np.dtype(_XYZ if view.colors is None else _XYZ + _RGBA)
    packed = np.zeros(len(view.points), layout)
    for i, axis in enumerate("xyz"):
        packed[axis] = view.points[:, i]
    if view.colors is not None:
        for i, channel in enumerate(("red", "green", "blue")):
            packed[channel] = view.colors[:, i]
        packed["alpha"] = 255
    message = PointCloud(frame_id="camera", point_stride=layout.itemsize, data=packed.tobytes())
    message.timestamp.FromNanoseconds(view.stamp_ns)
    message.pose.position.SetInParent()
    message.pose.orientation.w = 1.0
    for name in layout.names:
        kind = PackedElementField.FLOAT32 if name in "xyz" else PackedElementField.UINT8
        message.fields.add(name=name, offset=layout.fields[name][1], type=kind)
    return message


def _info_to_metadata(info: SessionInfo, views: int) -> dict[str, str]:
    origin = "unknown" if info.sensor_origin is None else " ".join(f"{c:g}" for c in info.sensor_origin)
    optional = {"elevation_deg": info.elevation_deg, "views_per_turn": info.views_per_turn}
    return {
        "name": info.name,
        "category": info.category or "",
        "instance": info.instance or "",
        "source": info.source,
        "sensor": info.sensor,
        "capture": info.capture,
        "sensor_origin": origin,
        "source_axes": info.source_axes,
        "source_units": info.source_units,
        "source_poses": info.source_poses,
        **{key: "" if value is None else f"{value:.12g}" for key, value in optional.items()},
        "views": str(views),
        "format_version": FORMAT_VERSION,
    }


# --- reading ---------------------------------------------------------------------------------------------------------


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
        start = path.open("rb").read(len(_MAGIC))
    except OSError as error:
        raise UnreadableRecording(path, f"cannot be read ({error.strerror})", "check its permissions") from None
    if start != _MAGIC:
        problem = "the file is empty" if not start else "not an MCAP file"
        raise UnreadableRecording(path, problem, "make a recording with 'orbitscan convert'")
    contents = _index(path) or _search(path)
    if POINTS_TOPIC not in contents.topics and not contents.clouds:
        topics = ", ".join(sorted(contents.topics)) or "none that can be read"
        raise UnreadableRecording(
            path, f"holds no {POINTS_TOPIC} (topics: {topics})", "make a recording with 'orbitscan convert'"
        )
    info, names = _describe(path, contents)
    return Session(
        info=info,
        names=names,
        load=partial(_load_view, path, contents.clouds, names),
        load_truth=partial(_load_truth, path, contents.poses),
        damage=contents.damage,
    )


@dataclass(frozen=True)
class _Contents:
    """Where in a file the messages are; `damage` says what is lost of it as a whole."""

    topics: set[str]
    metadata: Mapping[str, Mapping[str, str]]
    clouds: Mapping[int, int]  # view -> offset of its chunk
    poses: Mapping[int, int]  # view, or any distinct number -> offset of its chunk
    damage: str | None


def _index(path: Path) -> _Contents | None:
    """The contents by the file's summary; None where it has none, or one that does not fit our layout."""
    try:
        with path.open("rb") as stream:
            reader = make_reader(stream)
            summary = reader.get_summary()
            if summary is None or not summary.chunk_indexes or not _summary_is_whole(stream):
                return None
            metadata = {record.name: record.metadata for record in reader.iter_metadata()}
            ids = {channel.topic: channel.id for channel in summary.channels.values()}
            chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
            clouds = [c.chunk_start_offset for c in chunks if ids.get(POINTS_TOPIC) in c.message_index_offsets]
            pose_chunks = [c.chunk_start_offset for c in chunks if ids.get(POSES_TOPIC) in c.message_index_offsets]
            views = metadata["scan_session"]["views"]
            if len(clouds) != int(views) or summary.statistics is None:
                return None
            if summary.statistics.message_count != len(clouds) + len(pose_chunks):
                return None  # other topics, or several messages a chunk: somebody else's layout
    except _DAMAGE:
        return None
    return _Contents(set(ids), metadata, dict(enumerate(clouds)), dict(enumerate(pose_chunks)), None)


def _summary_is_whole(stream: IO[bytes]) -> bool:
    """Whether the summary has the CRC its footer tells; the library trusts it, and may take one view for another."""
    stream.seek(-(_FOOTER.size + len(_MAGIC)), os.SEEK_END)
    end = stream.tell() + _FOOTER.size - 4  # the CRC itself is left out
    _, _, start, _, crc = _FOOTER.unpack(stream.read(_FOOTER.size))
    stream.seek(start)
    return crc == 0 or zlib.crc32(stream.read(end - start)) == crc


def _search(path: Path) -> _Contents:
    """The contents of a file that is cut, damaged or not of our layout: every chunk that is still whole is used."""
    topics: dict[int, str] = {}
    metadata: dict[str, Mapping[str, str]] = {}
    messages: list[tuple[int, int, int]] = []  # channel, sequence, offset of the chunk
    broken = 0
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        complete = data[-len(_MAGIC) :] == _MAGIC and len(data) > 2 * len(_MAGIC)
        for offset, opcode in _records(data).items():
            try:
                content = _content(data, offset, opcode)
                if isinstance(content, Metadata):
                    metadata.setdefault(content.name, content.metadata)
                    continue
                for record in breakup_chunk(content, validate_crc=True):
                    if isinstance(record, Channel):
                        topics[record.id] = record.topic
                    elif isinstance(record, Message):
                        messages.append((record.channel_id, record.sequence, offset))
            except _DAMAGE:
                broken += 1
    topics = _summary_topics(path) | topics  # the chunk that declares a channel may be a lost one
    clouds = _by_sequence(messages, topics, POINTS_TOPIC, "scan_session" in metadata)
    poses_ = _by_sequence(messages, topics, POSES_TOPIC, "scan_session" in metadata)
    damage = None
    if not complete:
        damage = "the file is cut or damaged at its end"
    elif broken:
        damage = "parts of the file are damaged"
    return _Contents(set(topics.values()), metadata, clouds, poses_, damage)


def _records(data: mmap.mmap) -> dict[int, int]:
    """Offset -> opcode of the chunk and metadata records: by the file's framing as far as it goes, and by their look.

    A damaged length breaks the framing or, worse, steps over whole records; the look finds those.
    """
    found = {}
    offset = len(_MAGIC)
    while offset + _RECORD_HEADER.size <= len(data):
        opcode, length = _RECORD_HEADER.unpack_from(data, offset)
        if not 0x01 <= opcode <= 0x0F or offset + _RECORD_HEADER.size + length > len(data):
            break
        if opcode in (_CHUNK_OPCODE, _METADATA_OPCODE):
            found[offset] = opcode
        offset += _RECORD_HEADER.size + length
    for match in _CHUNK_SIGNATURE.finditer(data):
        found[match.start() - _BEFORE_CHUNK_SIGNATURE] = _CHUNK_OPCODE
    for match in _METADATA_SIGNATURE.finditer(data):
        if data[match.start() - _RECORD_HEADER.size] == _METADATA_OPCODE:
            found[match.start() - _RECORD_HEADER.size] = _METADATA_OPCODE
    return dict(sorted(found.items()))


def _content(data: mmap.mmap, offset: int, opcode: int) -> Any:
    """The chunk or metadata record at an offset, by its inner lengths, whatever its outer length says."""
    kind = Chunk if opcode == _CHUNK_OPCODE else Metadata
    return kind.read(ReadDataStream(_Window(data, offset + _RECORD_HEADER.size)))


class _Window:
    """The part of a buffer that mcap's records are read from, without copying the rest."""

    def __init__(self, data: mmap.mmap, position: int) -> None:
        self.data, self.position = data, position

    def read(self, length: int) -> bytes:
        if length > len(self.data) - self.position:
            raise ValueError("a length beyond the end of the file")
        self.position += length
        return self.data[self.position - length : self.position]


def _summary_topics(path: Path) -> dict[int, str]:
    """Channel -> topic by the summary, where there is one."""
    try:
        with path.open("rb") as stream:
            summary = make_reader(stream).get_summary()
            return {channel.id: channel.topic for channel in summary.channels.values()} if summary else {}
    except _DAMAGE:
        return {}


def _by_sequence(
    messages: list[tuple[int, int, int]], topics: Mapping[int, str], topic: str, ours: bool
) -> dict[int, int]:
    """View -> chunk offset of a topic's messages; by order where somebody else's writer left the sequence at zero."""
    found = [(sequence, offset) for channel, sequence, offset in messages if topics.get(channel) == topic]
    if not ours and len({sequence for sequence, _ in found}) < len(found):
        return {i: offset for i, (_, offset) in enumerate(found)}
    return dict(sorted(dict(reversed(found)).items()))  # the first of a number wins


def _describe(path: Path, contents: _Contents) -> tuple[SessionInfo, tuple[str, ...]]:
    """The session's facts and view names, from the metadata or, where these are lost, from the file itself."""
    raw = contents.metadata.get("scan_session", {})
    named = contents.metadata.get("scan_views", {})
    count = _number(raw.get("views")) or (max(contents.clouds, default=-1) + 1)
    count = max(int(count), max(contents.clouds, default=-1) + 1)
    names = tuple(named.get(str(i), f"view_{i:03d}") for i in range(min(count, 10**6)))
    origin = [_number(word) for word in raw.get("sensor_origin", "").split()]
    capture = raw.get("capture", "unknown")
    info = SessionInfo(
        name=raw.get("name") or path.name.removesuffix(".part").removesuffix(".mcap"),
        views=len(names),
        category=raw.get("category") or None,
        instance=raw.get("instance") or None,
        source=raw.get("source", ""),
        sensor=raw.get("sensor", ""),
        capture=capture if capture in ("circle", "unordered") else "unknown",
        sensor_origin=tuple(origin) if len(origin) == 3 and None not in origin else None,
        source_axes=raw.get("source_axes", "RDF"),
        source_units=raw.get("source_units", "m"),
        source_poses=raw.get("source_poses", ""),
        elevation_deg=_number(raw.get("elevation_deg")),
        views_per_turn=_number(raw.get("views_per_turn")),
    )
    return info, names


def _number(text: str | None) -> float | None:
    try:
        value = float(text or "")
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def _message(path: Path, offset: int, index: int | None) -> Message:
    """The message in the chunk at an offset (of view `index`, where given), its CRC checked."""
    with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
        records = breakup_chunk(_content(data, offset, _CHUNK_OPCODE), validate_crc=True)
    found = [record for record in records if isinstance(record, Message)]
    if index is not None and len(found) > 1:
        found = [record for record in found if record.sequence == index]
    if not found:
        raise ValueError("no message in its chunk")
    return found[0]


def _load_view(path: Path, clouds: Mapping[int, int], names: tuple[str, ...], index: int) -> View:
    offset = clouds.get(index)
    damage = "missing from the recording"
    if offset is not None:
        try:
            message = _message(path, offset, index)
            return _decode_cloud(message, index, names[index])
        except _DAMAGE as error:
            damage = f"damaged in the recording ({type(error).__name__})"
    return View(index, names[index], (index + 1) * 10**9, np.empty((0, 3), np.float32), None, damage)


def _decode_cloud(message: Message, index: int, name: str) -> View:
    cloud = PointCloud.FromString(message.data)
    fields = [field for field in cloud.fields if field.type in _NUMPY_TYPES]
    layout = np.dtype(
        {
            "names": [field.name for field in fields],
            "formats": [_NUMPY_TYPES[field.type] for field in fields],
            "offsets": [field.offset for field in fields],
            "itemsize": cloud.point_stride,
        }
    )
    packed = np.frombuffer(cloud.data, layout)
    points = np.stack([packed[axis].astype(np.float32) for axis in "xyz"], axis=1)
    colored = {"red", "green", "blue"} <= set(layout.names)
    colors = np.stack([packed[c] for c in ("red", "green", "blue")], axis=1).astype(np.uint8) if colored else None
    return View(index, name, message.log_time, points, colors)


def _load_truth(path: Path, chunks: Mapping[int, int]) -> dict[int, np.ndarray]:
    truth = {}
    for key, offset in chunks.items():
        try:
            message = _message(path, offset, None)
            transform = FrameTransform.FromString(message.data)
        except _DAMAGE:
            continue  # a lost pose is an unknown one
        t, q = transform.translation, transform.rotation
        index = message.sequence or key  # somebody else's writer may leave the sequence at zero
        truth[index] = poses.from_quaternion(
            np.array([t.x, t.y, t.z]), np.array([q.x, q.y, q.z, q.w]), f"{path.name}, pose of view {index}"
        )
    return truth
