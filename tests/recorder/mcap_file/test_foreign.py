"""Recordings of other writers: read where they hold what ours do, refused in one sentence where not."""

import numpy as np
import pytest
from mcap.writer import Writer as PlainWriter
from mcap_protobuf.writer import Writer

from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import UnreadableRecording
from orbitscan.recorder.mcap_file.messages import cloud_message, pose_message
from tests.recorder.mcap_file.session import make_session

SESSION = make_session()


def record(path, number, poses_number=None, chunk_size=2**20, **options):
    """Clouds and poses as another writer might leave them: no metadata, messages numbered its own way."""
    with path.open("wb") as stream, Writer(stream, chunk_size=chunk_size, **options) as writer:
        for view in SESSION.views():
            times = {"log_time": view.stamp_ns, "publish_time": view.stamp_ns}
            pose = pose_message(view.stamp_ns, SESSION.truth()[view.index])
            writer.write_message("/tf", pose, sequence=(poses_number or number)(view.index), **times)
            writer.write_message("/camera/points", cloud_message(view), sequence=number(view.index), **times)


@pytest.mark.parametrize("chunk_size", [1, 2**20])
@pytest.mark.parametrize("crcs", [True, False])
@pytest.mark.parametrize(
    "numbers", [[lambda i: i], [lambda i: 0], [lambda i: i + 1], [lambda i: 2**31 + 7 * i], [lambda i: 0, lambda i: i]]
)
def test_messages_numbered_in_any_way(tmp_path, numbers, chunk_size, crcs):
    record(tmp_path / "s.mcap", *numbers, chunk_size=chunk_size, enable_crcs=crcs)
    found = mcap_file.read(tmp_path / "s.mcap")
    assert found.damage is None
    assert found.info.views == 6
    for view in SESSION.views():
        np.testing.assert_array_equal(found.load(view.index).points, view.points)
    assert set(found.truth()) == set(range(6))
    for i, T in found.truth().items():
        np.testing.assert_allclose(T, SESSION.truth()[i], atol=1e-12)


def test_the_start_of_a_cut_recording_of_another_writer_is_read(tmp_path):
    path = tmp_path / "s.mcap"
    record(path, lambda i: i, chunk_size=1)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found = mcap_file.read(path)
    assert "cut" in found.damage
    assert 1 <= found.info.views < 6
    np.testing.assert_array_equal(found.load(0).points, SESSION.load(0).points)


def write_plain(path, topic, encoding, data=None, **options):
    writer = PlainWriter(str(path), **options)
    writer.start()
    channel = writer.register_channel(topic, encoding, writer.register_schema("some/Type", "ros2msg", b""))
    other = writer.register_channel("/rosout", encoding, 0)
    writer.add_message(other, 1, b"log", 1)
    if data is not None:
        writer.add_message(channel, 1, data, 1)
    writer.finish()


@pytest.mark.parametrize("chunked", [True, False])
def test_a_topic_without_messages_is_refused(tmp_path, chunked):
    write_plain(tmp_path / "s.mcap", "/camera/points", "protobuf", use_chunking=chunked)
    with pytest.raises(UnreadableRecording, match=r"s\.mcap: nothing was recorded on /camera/points; make"):
        mcap_file.read(tmp_path / "s.mcap")


@pytest.mark.parametrize("chunked", [True, False])
def test_another_encoding_is_refused(tmp_path, chunked):
    write_plain(tmp_path / "s.mcap", "/camera/points", "cdr", b"\x00\x01\x00\x00abc", use_chunking=chunked)
    with pytest.raises(UnreadableRecording, match="is encoded as 'cdr', not as a Foxglove PointCloud in protobuf"):
        mcap_file.read(tmp_path / "s.mcap")


def record_one(path, change, stamp_ns=5):
    message = cloud_message(SESSION.load(0))
    change(message)
    with path.open("wb") as stream, Writer(stream) as writer:
        writer.write_message("/camera/points", message, stamp_ns, stamp_ns)
    return mcap_file.read(path).load(0)


@pytest.mark.parametrize("stamp_ns", [2**63, 2**64 - 1])
def test_a_time_that_cannot_be_is_none(tmp_path, stamp_ns):
    assert record_one(tmp_path / "s.mcap", lambda _: None, stamp_ns).stamp_ns == 10**9


def test_points_in_double_precision_are_read_however_far_they_are(tmp_path):
    def change(message):
        message.data = np.array([[1.5, 2.5, 1e300], [0.25, -1e300, np.nan]]).tobytes()
        message.point_stride = 24
        del message.fields[3:]
        for i, field in enumerate(message.fields):
            field.offset, field.type = 8 * i, field.FLOAT64

    expected = [[1.5, 2.5, np.inf], [0.25, -np.inf, np.nan]]
    np.testing.assert_array_equal(record_one(tmp_path / "s.mcap", change).points, expected)


@pytest.mark.parametrize(
    "change",
    [
        lambda m: setattr(m, "point_stride", 0),
        lambda m: setattr(m, "point_stride", 2**32 - 1),
        lambda m: setattr(m.fields[0], "offset", 2**32 - 1),
        lambda m: setattr(m.fields[1], "name", "x"),
        lambda m: setattr(m, "data", m.data[:-1]),
        lambda m: m.ClearField("fields"),
    ],
)
def test_layouts_that_are_none_are_damage(tmp_path, change):
    assert "damaged" in record_one(tmp_path / "s.mcap", change).damage


def test_other_messages_are_damage(tmp_path):
    write_plain(tmp_path / "s.mcap", "/camera/points", "protobuf", b"\xff" * 30)
    assert "damaged" in mcap_file.read(tmp_path / "s.mcap").load(0).damage


def test_a_recording_attached_to_another_is_not_mixed_up_with_it(tmp_path):
    mcap_file.write(make_session(views=3, seed=5), tmp_path / "inner.mcap")
    path = tmp_path / "s.mcap"
    with path.open("wb") as stream, Writer(stream) as writer:
        writer.add_attachment(1, 1, "before.mcap", "application/mcap", (tmp_path / "inner.mcap").read_bytes())
        for view in SESSION.views():
            writer.write_message("/camera/points", cloud_message(view), view.stamp_ns, view.stamp_ns, view.index)
    found = mcap_file.read(path)
    assert (found.info.views, found.info.name) == (6, "s")
    path.write_bytes(path.read_bytes()[:-50])
    found = mcap_file.read(path)
    assert (found.info.views, found.info.name) == (6, "s")
    np.testing.assert_array_equal(found.load(1).points, SESSION.load(1).points)
