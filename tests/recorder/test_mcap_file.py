"""Sessions survive the file; what is lost of a damaged file is said, and nothing else is lost."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from recorder import mcap_file, poses
from recorder.exceptions import InvalidPose, ScanError, UnreadableRecording, UnwritableOutput
from recorder.session import SessionInfo, View, in_memory
from tests.geometry import random_pose


def make_session(views=6, points=200, colors=True, seed=0, missing=()):
    rng = np.random.default_rng(seed)
    clouds = [
        View(
            index=i,
            name=f"scan{i * 45:03d}",
            stamp_ns=1_700_000_000_123_456_789 + i,
            points=rng.normal(size=(points + i, 3)).astype(np.float32),
            colors=rng.integers(0, 256, (points + i, 3), dtype=np.uint8) if colors else None,
        )
        for i in range(views)
    ]
    info = SessionInfo(
        name="mug",
        views=views,
        category="coffee_mug",
        instance="3",
        source="clouds",
        sensor="Kinect",
        capture="circle",
        sensor_origin=(0.125, 0.0, -10.0),
        source_axes="RUB",
        source_units="mm",
        source_poses="object-to-camera RUB mm",
        elevation_deg=30.0,
        views_per_turn=17.25,
    )
    return in_memory(info, clouds, {i: random_pose(rng) for i in range(views) if i not in missing})


def assert_same_view(found, view):
    assert (found.index, found.name, found.stamp_ns, found.damage) == (view.index, view.name, view.stamp_ns, None)
    assert found.points.dtype == np.float32
    np.testing.assert_array_equal(found.points, view.points)
    if view.colors is None:
        assert found.colors is None
    else:
        assert found.colors.dtype == np.uint8
        np.testing.assert_array_equal(found.colors, view.colors)


def assert_same(found, session):
    assert found.info == session.info
    assert found.names == session.names
    for view in session.views():
        assert_same_view(found.load(view.index), view)
    assert set(found.truth()) == set(session.truth())
    for i, T in session.truth().items():
        np.testing.assert_allclose(found.truth()[i], T, atol=1e-12)


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "mug.mcap"
    mcap_file.write(make_session(), path)
    return path


@pytest.mark.parametrize("colors", [True, False])
@pytest.mark.parametrize("missing", [(), (0, 3), range(6)])
def test_a_session_there_and_back(tmp_path, colors, missing):
    session = make_session(colors=colors, missing=missing)
    mcap_file.write(session, tmp_path / "s.mcap")
    found = mcap_file.read(tmp_path / "s.mcap")
    assert_same(found, session)
    assert found.damage is None


def test_views_without_points_and_points_without_places(tmp_path):
    nothing, nowhere = np.empty((0, 3), np.float32), np.full((4, 3), np.nan, np.float32)
    some = np.array([[1, 2, 3], [np.nan, 0, 0], [np.inf, 0, -np.inf]], np.float32)
    views = [View(i, f"v{i}", i, points) for i, points in enumerate((nothing, nowhere, some))]
    mcap_file.write(in_memory(SessionInfo("odd", 3), views), tmp_path / "odd.mcap")
    found = mcap_file.read(tmp_path / "odd.mcap")
    for view in views:
        assert_same_view(found.load(view.index), view)


@pytest.mark.parametrize("name", ["bun000", "Becher groß", "视图", "a/b\\c", "1"])
def test_names_of_any_kind(tmp_path, name):
    view = View(0, name, 5, np.zeros((1, 3), np.float32))
    session = in_memory(SessionInfo(name, 1, category=None, sensor_origin=None), [view])
    mcap_file.write(session, tmp_path / "n.mcap")
    found = mcap_file.read(tmp_path / "n.mcap")
    assert (found.names, found.info) == ((name,), session.info)


def test_writing_twice_gives_the_same_bytes(tmp_path):
    mcap_file.write(make_session(), tmp_path / "a.mcap")
    mcap_file.write(make_session(), tmp_path / "b.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_the_session_stands_first_and_its_messages_are_foxglove_s(recording):
    with recording.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        schemas = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
        first_chunk = min(chunk.chunk_start_offset for chunk in summary.chunk_indexes)
        assert all(index.offset < first_chunk for index in summary.metadata_indexes)
        assert [record.name for record in reader.iter_metadata()] == ["scan_session", "scan_views"]
        found = [(c.topic, m.sequence, m.log_time == m.publish_time) for _, c, m in reader.iter_messages()]
    assert schemas == {"/camera/points": "foxglove.PointCloud", "/tf": "foxglove.FrameTransform"}
    assert len(summary.chunk_indexes) == 12
    assert found == [(topic, i, True) for i in range(6) for topic in ("/tf", "/camera/points")]


def test_a_view_is_read_without_the_others(recording):
    session = mcap_file.read(recording)
    damage_chunk(recording, cloud_offsets(recording)[1])
    assert_same_view(session.load(4), make_session().load(4))
    assert session.load(1).damage is not None


# --- what cannot be written or read ---------------------------------------------------------------------------------


def test_a_view_that_fails_leaves_nothing_behind(tmp_path):
    def load(index):
        if index == 3:
            raise UnreadableRecording("scan3.ply", "broken", "mend it")
        return make_session().load(index)

    (tmp_path / "s.mcap").write_bytes(b"what was there")
    with pytest.raises(UnreadableRecording):
        mcap_file.write(replace(make_session(), load=load), tmp_path / "s.mcap")
    assert [path.name for path in tmp_path.iterdir()] == ["s.mcap"]
    assert (tmp_path / "s.mcap").read_bytes() == b"what was there"


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("x")
    (tmp_path / "folder.mcap").mkdir()
    for path in (tmp_path / "file" / "s.mcap", Path("/dev/null/s.mcap"), tmp_path / "folder.mcap"):
        with pytest.raises(UnwritableOutput, match="cannot be written"):
            mcap_file.write(make_session(views=1), path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder.mcap"]


@pytest.mark.parametrize(
    ("content", "what"), [(b"", "the file is empty"), (b"ply\n", "not an MCAP"), (b"\x89MCAP0\r", "not an MCAP")]
)
def test_what_is_no_recording_is_refused(tmp_path, content, what):
    path = tmp_path / "s.mcap"
    path.write_bytes(content)
    with pytest.raises(UnreadableRecording, match=what):
        mcap_file.read(path)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    with pytest.raises(UnreadableRecording, match="no such file"):
        mcap_file.read(tmp_path / "s.mcap")
    with pytest.raises(UnreadableRecording, match="is a folder"):
        mcap_file.read(tmp_path)


@pytest.mark.parametrize("tail", [b"", b"\x89MCAP0\r\n", b"\x00" * 100])
def test_an_mcap_without_messages_is_refused(tmp_path, tail):
    path = tmp_path / "s.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + tail)
    with pytest.raises(UnreadableRecording, match="holds no /camera/points"):
        mcap_file.read(path)


def test_recordings_of_other_topics_are_refused_with_their_topics(data):
    bags = sorted((data / "mcap_ros2_rosbag2").glob("*.mcap")) + sorted(data.glob("mcap_rosbags_rs/*/*.mcap"))
    assert len(bags) == 19
    for bag in bags:
        with pytest.raises(UnreadableRecording, match="holds no /camera/points"):
            mcap_file.read(bag)
    with pytest.raises(UnreadableRecording, match="/topic"):
        mcap_file.read(data / "mcap_ros2_rosbag2" / "talker.mcap")


# --- damage ----------------------------------------------------------------------------------------------------------


def cloud_offsets(path):
    """Offset and length of each view's chunk."""
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    channel = next(c.id for c in summary.channels.values() if c.topic == "/camera/points")
    chunks = sorted(summary.chunk_indexes, key=lambda chunk: chunk.chunk_start_offset)
    return [(c.chunk_start_offset, c.chunk_length) for c in chunks if channel in c.message_index_offsets]


def damage_chunk(path, where):
    offset, length = where
    content = bytearray(path.read_bytes())
    content[offset + length // 2] ^= 0x10
    path.write_bytes(content)


@pytest.mark.parametrize("lost", [0, 2, 5])
def test_a_flipped_bit_costs_one_view(recording, lost):
    damage_chunk(recording, cloud_offsets(recording)[lost])
    session, truth = make_session(), make_session().truth()
    found = mcap_file.read(recording)
    for view in session.views():
        if view.index == lost:
            assert "damaged" in found.load(lost).damage
            assert len(found.load(lost).points) == 0
        else:
            assert_same_view(found.load(view.index), view)
    assert set(found.truth()) == set(truth)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_a_cut_file_gives_the_views_before_the_cut(recording, share):
    offsets = cloud_offsets(recording)
    content = recording.read_bytes()
    cut = int(len(content) * share)
    recording.write_bytes(content[:cut])
    found, session = mcap_file.read(recording), make_session()
    assert found.info == session.info
    assert found.names == session.names
    assert "cut" in found.damage
    whole = [i for i, (offset, length) in enumerate(offsets) if offset + length <= cut]
    assert 0 < len(whole) < 6
    for view in session.views():
        if view.index in whole:
            assert_same_view(found.load(view.index), view)
        else:
            assert "missing" in found.load(view.index).damage


def test_a_file_that_its_writer_left_open_is_read(recording):
    part = recording.with_name("mug.mcap.part")
    part.write_bytes(recording.read_bytes()[: cloud_offsets(recording)[3][0]])
    found = mcap_file.read(part)
    assert found.info.name == "mug"
    assert [found.load(i).damage is None for i in range(6)] == [True] * 3 + [False] * 3


def test_a_bit_flipped_anywhere_costs_at_most_the_view_it_is_in(recording):
    offsets = cloud_offsets(recording)
    content = recording.read_bytes()
    session = make_session()
    rng = np.random.default_rng(0)
    positions = [*rng.integers(0, len(content), 150), *range(0, 700, 11), *range(len(content) - 1200, len(content), 17)]
    refused = 0
    for position in positions:
        flipped = bytearray(content)
        flipped[position] ^= 1 << int(rng.integers(8))
        recording.write_bytes(flipped)
        hit = [i for i, (offset, length) in enumerate(offsets) if offset <= position < offset + length]
        try:
            found = mcap_file.read(recording)
            views = [found.load(i) for i in range(6)]
            truth = found.truth()
        except ScanError:
            refused += 1
            assert position < 8, f"the recording is refused for a bit at {position}"
            continue
        assert len(found.names) == 6, f"views appear for a bit at {position}"
        for view in views:
            if view.index not in hit:
                np.testing.assert_array_equal(view.points, session.load(view.index).points, f"bit at {position}")
                np.testing.assert_array_equal(view.colors, session.load(view.index).colors, f"bit at {position}")
            elif view.damage is None:
                np.testing.assert_array_equal(view.points, session.load(view.index).points, f"bit at {position}")
        for i, T in truth.items():
            np.testing.assert_allclose(T, session.truth()[i], atol=1e-12)
        assert len(truth) >= 5
    assert refused < 5


def test_bytes_behind_the_end_cost_nothing(recording):
    recording.write_bytes(recording.read_bytes() + b"\x00" * 50)
    found, session = mcap_file.read(recording), make_session()
    for view in session.views():
        assert_same_view(found.load(view.index), view)


def test_a_recorded_pose_that_is_no_rotation_is_refused_when_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(poses, "to_quaternion", lambda T: (0.5, 0.0, 0.0, 0.5))
    mcap_file.write(make_session(), tmp_path / "s.mcap")
    found = mcap_file.read(tmp_path / "s.mcap")
    assert_same_view(found.load(0), make_session().load(0))
    with pytest.raises(InvalidPose, match=r"s\.mcap, pose of view 0: a quaternion has the length 0\.707"):
        found.truth()
