"""`info` and `check`: what they tell of a recording, and how they end."""

from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.session import in_memory
from tests.recorder.cli.conftest import SESSION
from tests.recorder.mcap_file.session import cloud_offsets, damage_chunk


def test_a_recording_of_other_topics(orbitscan, data):
    status, _, err = orbitscan("check", data / "mcap_ros2_rosbag2" / "talker.mcap")
    assert status == 2
    assert "holds no /camera/points (topics: " in err


def test_info_tells_the_sizes_and_the_views_that_would_be_used(orbitscan, recording, data):
    status, out, _ = orbitscan("info", recording)
    rows = dict(line.split(maxsplit=1) for line in out.splitlines() if not line.startswith(("--", "poses")))
    assert status == 0
    assert rows["views"] == "5 (view_000 ... view_004)"
    sides = [float(side) for side in rows["extent"].split(" cm")[0].split(" x ")]
    assert len(sides) == 3
    assert all(5 < side < 35 for side in sides)
    assert 800 < float(rows["distance"].removesuffix(" mm")) < 1000
    assert "poses known  5 of 5\n" in out
    assert "--views 18   all\n" in out
    orbitscan("convert", data / "washington" / "rgbd-dataset" / "cap", "-o", "cap.mcap")
    _, out, _ = orbitscan("info", "cap.mcap")
    assert "--views 18   0 2 4 6 8 10 12 14 16 19 21 23 25 27 29 31 33 35\n" in out
    assert "category     cap 1\n" in out
    assert "poses known  0 of 38\n" in out


def test_info_of_a_damaged_recording(orbitscan, recording):
    damage_chunk(recording, cloud_offsets(recording)[2])
    content = recording.read_bytes()
    recording.write_bytes(content[:-100])
    status, out, _ = orbitscan("info", recording)
    assert status == 0
    assert "damage       the file is cut or damaged at its end; view 2 unreadable\n" in out
    assert "points       0 / " in out


def test_check_of_a_good_and_of_a_bad_recording(orbitscan, recording):
    status, out, err = orbitscan("check", recording)
    assert (status, err) == (0, "")
    assert out.startswith("info: poses align the views to ")
    assert out.endswith(f"next: orbitscan process {recording} -o results\n")
    views = [SESSION.load(0), *list(SESSION.views())[1:]]
    mcap_file.write(in_memory(SESSION.info, views, {i: poses.invert(T) for i, T in SESSION.truth().items()}), recording)
    status, out, _ = orbitscan("check", recording)
    assert status == 1
    assert out.startswith("problem: poses: ")
    assert "next:" not in out


def test_check_of_a_cut_recording(orbitscan, recording):
    content = recording.read_bytes()
    recording.write_bytes(content[: len(content) // 2])
    status, out, _ = orbitscan("check", recording)
    assert status == 1
    assert out.startswith("problem: the file is cut or damaged at its end; record the session again\nproblem: views ")
