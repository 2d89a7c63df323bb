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

_RGB = ("red", "green", "blue")
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
    packed = np.zeros(len(view.points), [("points", "<f4", 3), ("rgba", "u1", 0 if view.colors is None else 4)])
    packed["points"] = view.points
    fields = [(axis, PackedElementField.FLOAT32, 4 * i) for i, axis in enumerate("xyz")]
    if view.colors is not None:
        packed["rgba"] = np.insert(view.colors, 3, 255, axis=1)
        fields += [(channel, PackedElementField.UINT8, 12 + i) for i, channel in enumerate((*_RGB, "alpha"))]
    message = PointCloud(frame_id=_CAMERA, point_stride=packed.itemsize, data=packed.tobytes())
    message.timestamp.FromNanoseconds(view.stamp_ns)
    message.pose.position.SetInParent()
    message.pose.orientation.w = 1.0
    for name, kind, offset in fields:
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
    colored = set(_RGB) <= set(layout.names or ())
    colors = np.stack([packed[channel] for channel in _RGB], axis=1).astype(np.uint8) if colored else None
    stamp_ns = message.log_time if message.log_time < 2**63 else (index + 1) * 10**9  # no time after the year 2262
    return View(index, name, stamp_ns, points, colors)
