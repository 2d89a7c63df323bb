"""A recording whose writer is at work is told from one that is complete, and from one that was cut for good."""

import os
import subprocess
import sys
import time

import pytest

from orbitscan.recorder.mcap_file import still_being_written
from tests.recorder.mcap_file.session import cloud_offsets

LONG_AGO = time.time() - 3600
on_linux = pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells who has a file open")


def cut(recording, modified=LONG_AGO):
    recording.write_bytes(recording.read_bytes()[: cloud_offsets(recording)[3][0] + 50])
    os.utime(recording, (modified, modified))


def test_a_complete_recording_is_not_being_written_however_young(recording, monkeypatch):
    monkeypatch.setattr("time.sleep", lambda _: pytest.fail("waits"))
    assert not still_being_written(recording)
    with recording.open("ab"):
        assert not still_being_written(recording)


def test_a_cut_recording_is_being_written_as_long_as_it_is_not_quiet(recording):
    cut(recording, time.time())
    assert still_being_written(recording)
    os.utime(recording, (time.time() - 20,) * 2)
    assert not still_being_written(recording)
    assert still_being_written(recording, quiet_s=60)


def test_a_date_far_in_the_future_is_a_wrong_clock(recording):
    cut(recording, time.time() + 3600)
    assert not still_being_written(recording)


@on_linux
def test_a_silent_writer_that_holds_the_file_open_is_at_work(recording):
    cut(recording)
    with recording.open("rb"):
        assert not still_being_written(recording)
    with recording.open("ab"):
        assert still_being_written(recording)
    assert not still_being_written(recording)


@on_linux
def test_a_writer_in_another_process(recording):
    cut(recording)
    holds = "import sys; file = open(sys.argv[1], 'r+b'); print('open', flush=True); sys.stdin.read()"
    arguments = [sys.executable, "-c", holds, recording]
    with subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as writer:
        writer.stdout.readline()
        assert still_being_written(recording)
        writer.communicate()
    assert not still_being_written(recording)


def test_a_recording_that_has_just_begun_is_being_written(tmp_path):
    path = tmp_path / "s.mcap"
    for content in (b"", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" * 9):
        path.write_bytes(content)
        assert still_being_written(path), content


def test_a_file_that_is_not_there_is_not_being_written(tmp_path):
    assert not still_being_written(tmp_path / "s.mcap")
    assert not still_being_written(tmp_path)
