"""A picture of a recording: the PNG that was asked for, or one sentence and nothing."""

import struct
from contextlib import contextmanager

import pytest
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.review import entities, picture
from orbitscan.processing.review.picture import NoViewer, find_viewer, open_viewer, take_picture
from orbitscan.processing.review.recording import whole_recording
from orbitscan.recorder.exceptions import InvalidOption, UnwritableOutput


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A word at each of three views."""
    path = tmp_path_factory.mktemp("recording") / "words.rrd"
    words = rrb.TextDocumentView(origin="/word")
    panel = rrb.TimePanel(state="collapsed", timeline=entities.VIEW_TIMELINE, play_state="following")
    with whole_recording(path, "words", rrb.Blueprint(words, panel)) as stream:
        for view, word in enumerate(("one", "two", "three")):
            stream.set_time(entities.VIEW_TIMELINE, sequence=view)
            stream.log("/word", rr.TextDocument(word))
    return path


def size_of(path):
    """Width and height of a PNG."""
    return struct.unpack(">II", path.read_bytes()[16:24])


def test_a_picture_has_its_size_and_is_taken_at_the_cursor(recording, tmp_path, monkeypatch):
    cursors = []

    @contextmanager
    def watched(*arguments):
        with open_viewer(*arguments) as viewer:
            yield viewer
            cursors.append(viewer.get_state().recordings[0].current_time)

    monkeypatch.setattr(picture, "open_viewer", watched)
    try:
        assert take_picture(recording, tmp_path / "end.png", "900x600") == []
        assert take_picture(recording, tmp_path / "one.png", "900x600", view=1) == []
    except NoViewer as reason:
        pytest.skip(str(reason))
    assert size_of(tmp_path / "end.png") == size_of(tmp_path / "one.png") == (900, 600)
    assert cursors == [2, 1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["end.png", "one.png"]


@pytest.mark.parametrize(
    ("name", "view", "error", "says"),
    [
        ("a.jpg", None, UnwritableOutput, "a picture is a PNG"),
        ("nowhere/a.png", None, UnwritableOutput, "its folder does not exist"),
        ("a.png", 99, InvalidOption, "no such view"),
    ],
)
def test_what_cannot_be_taken_is_told_before_a_viewer_starts(recording, tmp_path, monkeypatch, name, view, error, says):
    monkeypatch.setattr(picture, "open_viewer", lambda *_: pytest.fail("a viewer starts"))
    with pytest.raises(error, match=says):
        take_picture(recording, tmp_path / name, view=view)
    assert list(tmp_path.iterdir()) == []


def test_a_viewer_that_does_not_start_is_told(recording, tmp_path, monkeypatch):
    monkeypatch.setenv("RERUN_CLI_PATH", str(tmp_path / "missing"))
    with pytest.raises(NoViewer, match="not there"):
        find_viewer()
    ends = tmp_path / "rerun"
    ends.write_text("#!/bin/sh\nexit 1\n")
    ends.chmod(0o755)
    monkeypatch.setenv("RERUN_CLI_PATH", str(ends))
    with pytest.raises(NoViewer, match="does not start"), open_viewer(recording):
        pass
