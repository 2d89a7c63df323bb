"""What becomes of a recording: results that are whole, or a sentence."""

import json
import os
from dataclasses import replace

import pytest

from orbitscan.processing.batch import recording as batch
from orbitscan.processing.batch.inputs import find_recordings
from orbitscan.processing.batch.recording import Job, process_recording
from orbitscan.processing.pipeline import process
from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import UnreadableRecording
from tests.geometry import scan

SMALL = {"views": "2", "methods": ("icp",), "model": None}


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recordings") / "blob.mcap"
    mcap_file.write(scan(n_views=2, points=4000), path)
    return path


def test_recordings_among_results_are_no_inputs(recording, tmp_path):
    assert process_recording(recording, Job(tmp_path / "out", **SMALL)).status == "done"
    assert (tmp_path / "out" / "blob" / "registered.mcap").exists()
    with pytest.raises(UnreadableRecording):
        find_recordings([tmp_path])


def test_a_recording_that_somebody_writes_is_left_for_later(recording, tmp_path):
    growing = tmp_path / "blob.mcap"
    growing.write_bytes(recording.read_bytes()[:-40])
    job = Job(tmp_path / "out", skip_unfinished=True, **SMALL)
    assert process_recording(growing, job).status == "unfinished"
    assert not (tmp_path / "out").exists()
    os.utime(growing, (1e9, 1e9))  # nobody has written for years: it was cut
    outcome = process_recording(growing, job)
    assert outcome.status == "done"
    assert "cut" in outcome.damage


def test_a_recording_that_changes_meanwhile_has_no_results(recording, tmp_path, monkeypatch):
    changing = tmp_path / "blob.mcap"
    changing.write_bytes(recording.read_bytes())

    def change(*arguments):
        os.utime(changing, (1e9, 1e9))
        return process(*arguments)

    monkeypatch.setattr(batch, "process", change)
    outcome = process_recording(changing, Job(tmp_path / "out", **SMALL))
    assert "it changed while it was read" in outcome.message
    assert not list((tmp_path / "out").iterdir())


def test_a_fault_of_ours_is_a_sentence_and_a_file_for_a_report(recording, tmp_path, monkeypatch):
    def fail(*arguments):
        raise ZeroDivisionError("of a\nmodel")

    monkeypatch.setattr(batch, "process", fail)
    outcome = process_recording(recording, Job(tmp_path, **SMALL))
    assert outcome.status == "failed"
    assert "a fault of orbitscan stopped it (ZeroDivisionError: of a model); please report it with" in outcome.message
    assert [path.name for path in tmp_path.iterdir()] == ["blob.traceback.txt"]
    assert "ZeroDivisionError" in (tmp_path / "blob.traceback.txt").read_text()
    monkeypatch.undo()
    assert process_recording(recording, Job(tmp_path, **SMALL)).status == "done"
    assert [path.name for path in tmp_path.iterdir()] == ["blob"]


def test_figures_are_drawn_of_results_that_are_done(recording, tmp_path):
    job = Job(tmp_path, **SMALL)
    process_recording(recording, job)
    made = (tmp_path / "blob" / "review.rrd").stat().st_mtime_ns
    assert process_recording(recording, replace(job, figures=True)).message == "already done"
    assert (tmp_path / "blob" / "review.rrd").stat().st_mtime_ns == made
    assert {path.name for path in (tmp_path / "blob" / "figures").iterdir()} == {"errors.png", "errors.svg"}


def test_overwriting_makes_the_same_bytes_again(recording, tmp_path):
    job = Job(tmp_path, **SMALL)
    process_recording(recording, job)
    first = (tmp_path / "blob" / "results.json").read_bytes()
    outcome = process_recording(recording, replace(job, overwrite=True))
    assert outcome.message == "done again"
    assert (tmp_path / "blob" / "results.json").read_bytes() == first
    assert json.loads(first)["session"]["views_used"] == [0, 1]
