"""Sessions survive the file, which other tools understand."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import UnreadableRecording, UnwritableOutput
from orbitscan.recorder.session import SessionInfo, View, in_memory
from tests.recorder.mcap_file.session import assert_same, assert_same_view, make_session


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
