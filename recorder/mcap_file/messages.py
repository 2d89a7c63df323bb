"""Views and true poses as Foxglove messages, and back."""

import contextlib

import numpy as np
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from google.protobuf.message import DecodeError
from mcap.records import Message

from orbitscan.recorder import poses
from orbitscan.recorder.session import View

POINTS_TOPIC = "/camera/points"
POSES_TOPIC = "/tf"
ENCODING = "protobuf"

_OBJECT, _CAMERA = "object", "camera"  # the frames

_XYZ = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
_RGBA = [("red", "u1"), ("green", "u1"), ("blue", "u1"), ("alpha", "u1")]
_NUMPY_TYPES = {
    PackedElementField.UINT8: "u1", PackedElementField.INT8: "i1",
    PackedElementField.UINT16: "<u2", PackedElementField.INT16: "<i2",
    PackedElementField.UINT32: "<u4", PackedElementField.INT32: "<i4",
    PackedElementField.FLOAT32: "<f4", PackedElementField.FLOAT64: "<f8",
}  # fmt: skip


def pose_message(stamp_ns: int, T_object_camera: np.ndarray) -> FrameTransform:
    """A true pose, from `object` to `camera`."""
    message = FrameTransform(parent_frame_id=_OBJECT, child_frame_id=_CAMERA)
    message.timestamp.FromNanoseconds(stamp_ns)
    x, y, z = T_object_camera[:3, 3]
    message.translation.x, message.translation.y, message.translation.z = x, y, z
    qx, qy, qz, qw = poses.to_quaternion(T_object_camera)
    message.rotation.x, message.rotation.y, message.rotation.z, message.rotation.w = qx, qy, qz, qw
    return message


def cloud_message(view: View) -> PointCloud:
    """A view's points [m] and colours, in the frame `camera`."""
    layout = np.dtype(_XYZ if view.colors is None else _XYZ + _RGBA)
    packed = np.zeros(len(view.points), layout)
    for i, axis in enumerate("xyz"):
        packed[axis] = view.points[:, i]
    if view.colors is not None:
        for i, channel in enumerate(("red", "green", "blue")):
            packed[channel] = view.colors[:, i]
        packed["alpha"] = 255
    message = PointCloud(frame_id=_CAMERA, point_stride=layout.itemsize, data=packed.tobytes())
    message.timestamp.FromNanoseconds(view.stamp_ns)
    message.pose.position.SetInParent()
    message.pose.orientation.w = 1.0
    for name, (_, offset, *_) in (layout.fields or {}).items():
        kind = PackedElementField.FLOAT32 if name in "xyz" else PackedElementField.UINT8
        message.fields.add(name=name, offset=offset, type=kind)
    return message


def look_like(content: bytes) -> str | None:
    """The topic of a message of ours by its content, where the record that declares its channel is lost."""
    with contextlib.suppress(DecodeError):
        transform = FrameTransform.FromString(content)
        if (transform.parent_frame_id, transform.child_frame_id) == (_OBJECT, _CAMERA):
            return POSES_TOPIC
    with contextlib.suppress(DecodeError):
        cloud = PointCloud.FromString(content)
        if cloud.frame_id == _CAMERA and {"x", "y", "z"} <= {field.name for field in cloud.fields}:
            return POINTS_TOPIC
    return None


def decode_cloud(message: Message, index: int, name: str) -> View:
    """The view that a cloud's message holds. Raises one of DAMAGE where it holds no points."""
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
    with np.errstate(over="ignore"):  # what is too far for float32 is infinitely far
        points = np.stack([packed[axis].astype(np.float32) for axis in "xyz"], axis=1)
    colored = {"red", "green", "blue"} <= set(layout.names or ())
    colors = np.stack([packed[c] for c in ("red", "green", "blue")], axis=1).astype(np.uint8) if colored else None
    stamp_ns = message.log_time if message.log_time < 2**63 else (index + 1) * 10**9  # no time after the year 2262
    return View(index, name, stamp_ns, points, colors)
