"""Recordings side by side: one that kills its process takes no other along, and no worker outlives its parent."""

import multiprocessing
import os
import subprocess
import sys
import time

import filelock
import psutil
import pytest

from orbitscan.processing.batch import workers
from orbitscan.processing.batch.recording import Job, Outcome
from orbitscan.processing.batch.workers import process_all
from orbitscan.recorder.exceptions import InvalidOption


def die_of_some(path, job):
    """In place of processing: one recording kills its process, as lack of memory does."""
    time.sleep(0.05)
    if path.stem.startswith("deadly"):
        os._exit(1)
    return Outcome(path, job.results / path.stem, "done")


def wait_for_ever(path, job):
    """In place of processing."""
    (job.results / f"{os.getpid()}.pid").touch()
    time.sleep(600)


@pytest.fixture
def forked(monkeypatch):
    """Workers forked off a process that has imported everything; where the system has no fork, each imports again."""
    if "forkserver" in multiprocessing.get_all_start_methods():
        multiprocessing.set_forkserver_preload([workers.__name__, __name__])
        context = multiprocessing.get_context("forkserver")
        monkeypatch.setattr(multiprocessing, "get_context", lambda method: context)


@pytest.mark.usefixtures("forked")
def test_a_recording_that_kills_its_worker_is_a_row_and_the_others_are_done(tmp_path, monkeypatch):
    monkeypatch.setattr(workers, "process_recording", die_of_some)
    recordings = [tmp_path / f"{name}.mcap" for name in ("a", "b", "deadly_1", *"cdefghijk", "deadly_2", "l")]
    found = {outcome.recording: outcome for outcome in process_all(recordings, Job(tmp_path / "out"), 2)}
    assert sorted(found) == sorted(recordings)
    assert {path.stem for path, outcome in found.items() if outcome.error} == {"deadly_1", "deadly_2"}
    assert "its process died" in found[recordings[2]].message


def test_one_process_at_a_time_writes_into_results(tmp_path):
    with filelock.FileLock(tmp_path / ".orbitscan.lock"), pytest.raises(InvalidOption, match="another orbitscan"):
        next(process_all([tmp_path / "a.mcap"], Job(tmp_path)))
    (outcome,) = process_all([tmp_path / "a.mcap"], Job(tmp_path))
    assert outcome.status == "failed"
    assert not list(tmp_path.iterdir())


PARENT = """
from pathlib import Path
import sys
from orbitscan.processing.batch import workers
from orbitscan.processing.batch.recording import Job
from tests.processing.batch.test_workers import wait_for_ever
if __name__ == "__main__":
    workers.process_recording = wait_for_ever
    out = Path(sys.argv[1])
    list(workers.process_all([Path("a.mcap"), Path("b.mcap")], Job(out), 2))
"""


@pytest.mark.parametrize("signal_name", ["kill", "terminate"])
def test_no_worker_outlives_its_parent(signal_name, tmp_path):
    (tmp_path / "parent.py").write_text(PARENT)
    environment = os.environ | {"PYTHONPATH": os.getcwd()}
    parent = subprocess.Popen([sys.executable, tmp_path / "parent.py", tmp_path], env=environment)
    try:
        workers_of = wait_until(lambda: len(list(tmp_path.glob("*.pid"))) == 2 and list(tmp_path.glob("*.pid")))
    finally:
        getattr(parent, signal_name)()
    parent.wait()
    wait_until(lambda: not any(psutil.pid_exists(int(path.stem)) for path in workers_of))


def wait_until(condition, seconds=60):
    """The first true answer."""
    deadline = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return found
