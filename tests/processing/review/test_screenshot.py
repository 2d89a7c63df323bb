"""A picture of a recording: the PNG that was asked for, or one sentence and nothing."""

import os
import struct
import subprocess
import sys
from collections import Counter
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
import rerun as rr
import rerun.blueprint as rrb

from orbitscan.processing.review import entities, screenshot
from orbitscan.processing.review.screenshot import NoViewer, find_viewer, open_viewer, take_picture
from orbitscan.processing.review.stream import whole_recording
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


@pytest.mark.usefixtures("renderer")
def test_a_picture_has_its_size_and_is_taken_at_the_cursor(recording, tmp_path, monkeypatch):
    cursors = []

    @contextmanager
    def watched(*arguments):
        with open_viewer(*arguments) as viewer:
            yield viewer
            cursors.append(viewer.get_state().recordings[0].current_time)

    monkeypatch.setattr(screenshot, "open_viewer", watched)
    assert take_picture(recording, tmp_path / "end.png", "900x600") == []
    assert take_picture(recording, tmp_path / "one.png", "900x600", view=1) == []
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
    monkeypatch.setattr(screenshot, "open_viewer", lambda *_: pytest.fail("a viewer starts"))
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
    with pytest.raises(NoViewer, match="the viewer: ended with status 1; see whether 'rerun' starts here"):
        take_picture(recording, tmp_path / "a.png")


def test_a_viewer_that_dies_for_want_of_a_driver_is_told_as_that(recording, tmp_path, monkeypatch):
    monkeypatch.setenv("VK_DRIVER_FILES", "/nonexistent")
    with pytest.raises(NoViewer, match=r"finds no Vulkan driver; .*apt install mesa-vulkan-drivers libvulkan1"):
        take_picture(recording, tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("Failed to create headless render context: no adapter", "finds no Vulkan driver"),  # libvulkan, but no driver
        ("Failed to create render state: No graphics adapter was found", "finds no Vulkan driver"),  # not even that
        ("thread 'main' panicked at 'no room'", r"ended with status 102 \(thread 'main' panicked at 'no room'"),
    ],
)
def test_a_viewers_last_words_are_told_as_what_they_mean(recording, monkeypatch, tmp_path, words, says):
    dies = tmp_path / "rerun"
    dies.write_text(f'#!/bin/sh\necho "{words}" >&2\nexit 102\n')
    dies.chmod(0o755)
    monkeypatch.setenv("RERUN_CLI_PATH", str(dies))
    with pytest.raises(NoViewer, match=says):
        take_picture(recording, tmp_path / "a.png")


def test_the_suites_own_probe_says_why_nothing_is_drawn():
    """Without a driver every test that looks at pictures skips, with this as its reason."""
    hidden = os.environ | {"VK_DRIVER_FILES": "/nonexistent"}
    finished = subprocess.run([sys.executable, "-m", "tests.viewer"], env=hidden, capture_output=True, text=True)
    assert finished.returncode == 1
    assert finished.stderr.strip().startswith("the viewer: does not start without a display here: it finds no Vulkan")


class SlowViewer:
    """Answers each question at the third time only; the real one says so when a machine is slow."""

    def __init__(self):
        self.asked = Counter()

    def __getattr__(self, name):
        def answer(*_, **__):
            self.asked[name] += 1
            if self.asked[name] % 3:
                raise ConnectionError("Deadline expired before operation could complete")
            return SimpleNamespace(loading=False, recordings=["one"])

        return answer


def test_a_slow_viewer_is_waited_for(recording, monkeypatch, tmp_path):
    slow, waits = SlowViewer(), tmp_path / "rerun"
    waits.write_text("#!/bin/sh\nexec sleep 60\n")
    waits.chmod(0o755)
    monkeypatch.setenv("RERUN_CLI_PATH", str(waits))
    monkeypatch.setattr(screenshot, "ViewerClient", SimpleNamespace(connect=lambda _: slow))
    with open_viewer(recording) as viewer:
        assert viewer.get_state().recordings == ["one"]
    assert slow.asked["open"] == 3
    monkeypatch.setattr(screenshot, "SECONDS_TO_LOAD", 0.0)
    with pytest.raises(NoViewer, match="does not answer within 0 s; try again"), open_viewer(recording):
        pass
