"""A recording has an identity that every viewer takes; one that grows is in the file and in a viewer."""

import re
import shutil
import socket
import subprocess
import time
from collections import namedtuple

import pytest
import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader
from rerun.experimental import ViewerClient

from orbitscan.processing.review.stream import GrowingRecording, is_address, is_open, whole_recording
from tests import viewer
from tests.processing.review.recordings import read_all


def write(folder, name):
    path = folder / "recording.rrd"
    with whole_recording(path, name, rrb.Blueprint(rrb.TextDocumentView(origin="/word"))) as stream:
        stream.log("/word", rr.TextDocument("a word"), static=True)
    return path


@pytest.mark.usefixtures("renderer")
@pytest.mark.parametrize("name", ["tasse☕", "größe", "mug.2", "a b/c", "☕", "plain-name_1"])
def test_any_name_is_shown_as_it_is_and_drawn(name, tmp_path, capfd):
    path = write(tmp_path, name)
    with viewer.open_viewer(path) as client:
        assert viewer.find_reports(client) == []
    assert "WARN" not in "".join(capfd.readouterr())


@pytest.mark.parametrize("name", ["tasse☕", "größe", "mug.2"])
def test_the_identity_is_a_slug_and_the_name_is_kept(name, tmp_path):
    path = write(tmp_path, name)
    (entry,) = RrdReader(path).recordings()
    assert re.fullmatch(r"[A-Za-z0-9_-]+", entry.application_id)
    assert entry.recording_id == entry.application_id
    assert read_all(path, "/__properties/**", "RecordingInfo:name") == [name]


def test_a_plain_name_is_the_identity_and_other_names_have_others(tmp_path):
    names = ("mug", "größe", "gr-e", "grösse", "mug.2", "mug-2")
    entries = [RrdReader(write(tmp_path, name)).recordings()[0].application_id for name in names]
    assert entries[0] == "orbitscan-mug"
    assert len(set(entries)) == len(names)


def count(path, entity="/x"):
    return sum(chunk.num_rows for chunk in RrdReader(path).stream() if chunk.entity_path == entity)


def log(recording, views):
    for view in views:
        recording.stream.set_time("view", sequence=view)
        recording.stream.log("/x", rr.Scalars(float(view)))
        recording.flush()


def test_without_a_viewer_nothing_is_lost_and_nothing_waits(tmp_path):
    begun = time.monotonic()
    recording = GrowingRecording(tmp_path / "r.rrd", "test", "rerun+http://127.0.0.1:9/proxy")
    log(recording, range(3))
    assert count(tmp_path / "r.rrd") == 3  # readable before it is complete
    recording.stream.disconnect()
    assert time.monotonic() - begun < 5
    assert subprocess.run([viewer.RERUN, "rrd", "verify", tmp_path / "r.rrd"], capture_output=True).returncode == 0


@pytest.mark.parametrize("text", ["nowhere", "http://127.0.0.1:9876", "rerun+http://127.0.0.1/proxy", "rerun://h:x/"])
def test_no_address_of_a_viewer(text):
    assert not is_address(text)


def test_no_viewer_at_an_address():
    assert is_address("rerun+http://no-such-host.invalid:9876/proxy")
    assert not is_open("rerun+http://no-such-host.invalid:9876/proxy")


@pytest.mark.usefixtures("renderer")
def test_a_viewer_shows_it_as_it_grows_and_may_go_away(tmp_path):
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    address = f"rerun+http://127.0.0.1:{port}/proxy"
    command = [viewer.RERUN, "--headless", "--hide-welcome-screen", "--bind", "127.0.0.1", "--port", str(port)]
    window = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: is_open(address))
        recording = GrowingRecording(tmp_path / "r.rrd", "test", address)
        client = ViewerClient.connect(address)
        log(recording, range(3))
        wait_until(lambda: last_view(client) == 2)
        log(recording, range(3, 5))
        wait_until(lambda: last_view(client) == 4)
    finally:
        window.kill()
        window.wait()
    begun = time.monotonic()
    log(recording, range(5, 8))
    recording.stream.disconnect()
    assert time.monotonic() - begun < 5
    assert count(tmp_path / "r.rrd") == 8


def last_view(client: ViewerClient):
    for recording in client.get_state().recordings:
        for timeline in recording.timelines:
            if timeline.name == "view":
                return timeline.end
    return None


def wait_until(condition, seconds=20):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.1)


def test_a_disk_without_room_is_told_before_it_is_full(tmp_path, monkeypatch):
    recording = GrowingRecording(tmp_path / "r.rrd", "test")
    usage = namedtuple("usage", "total used free")
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: usage(9e6, 6e6, 3e6))
    recording.reserve(1_000_000)
    with pytest.raises(OSError, match="No space left"):
        recording.reserve(2_500_000)
    recording.stream.disconnect()
