"""A view is read on its own; what is no recording is refused."""

import pytest

from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.exceptions import InvalidPose, UnreadableRecording
from tests.recorder.mcap_file.session import assert_same_view, cloud_offsets, damage_chunk, make_session


def test_a_view_is_read_without_the_others(recording):
    session = mcap_file.read(recording)
    damage_chunk(recording, cloud_offsets(recording)[1])
    assert_same_view(session.load(4), make_session().load(4))
    assert session.load(1).damage is not None


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


def test_a_recorded_pose_that_is_no_rotation_is_refused_when_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(poses, "to_quaternion", lambda T: (0.5, 0.0, 0.0, 0.5))
    mcap_file.write(make_session(), tmp_path / "s.mcap")
    found = mcap_file.read(tmp_path / "s.mcap")
    assert_same_view(found.load(0), make_session().load(0))
    with pytest.raises(InvalidPose, match=r"s\.mcap, pose of view 0: a quaternion has the length 0\.707"):
        found.truth()
