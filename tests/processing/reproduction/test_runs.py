"""Runs are kept in files: what is finished is not done again, what is damaged or another's is."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import torch

from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.runs import keep
from tests.processing.reproduction.draws import Draw

SLOW = """
import sys
from pathlib import Path
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.runs import keep
from tests.processing.reproduction.draws import Draw, draw_slowly

if __name__ == "__main__":
    keep(Plan(Path(sys.argv[1]), workers=2), draw_slowly, [Draw(i) for i in range(6)], "Drawing")
"""


def draw(task):
    calls.append(task)
    return {"number": task.scale * np.random.default_rng(task.seed).normal(), "threads": torch.get_num_threads()}


calls = []


@pytest.fixture(autouse=True)
def _forget():
    calls.clear()


def test_results_come_in_the_order_of_the_tasks_and_are_worked_out_once(tmp_path):
    tasks = [Draw(i) for i in (3, 1, 2)]
    first = keep(Plan(tmp_path), draw, tasks, "Drawing")
    again = keep(Plan(tmp_path), draw, tasks[::-1], "Drawing")
    assert [result["number"] for result in first] == [np.random.default_rng(i).normal() for i in (3, 1, 2)]
    assert again == first[::-1]
    assert calls == tasks


def test_a_run_is_worked_on_with_one_thread_and_the_threads_come_back(tmp_path):
    before = torch.get_num_threads()
    assert keep(Plan(tmp_path), draw, [Draw(0)], "Drawing")[0]["threads"] == 1
    assert torch.get_num_threads() == before


@pytest.mark.parametrize("damage", ["", '{"key": 1}', '{"key": {"seed": 0}, "result": {}}'])
def test_a_damaged_file_is_made_again(tmp_path, damage):
    (first,) = keep(Plan(tmp_path), draw, [Draw(0)], "Drawing")
    (path,) = (tmp_path / "runs").iterdir()
    path.write_text(damage)
    assert keep(Plan(tmp_path), draw, [Draw(0)], "Drawing") == [first]
    assert json.loads(path.read_text())["result"] == first


def test_another_key_is_another_run(tmp_path):
    (one,), (two,) = (keep(Plan(tmp_path), draw, [Draw(0, scale)], "Drawing") for scale in (1.0, 2.0))
    assert two["number"] == 2 * one["number"]
    assert len(list((tmp_path / "runs").iterdir())) == 2


def test_a_failure_keeps_what_was_finished(tmp_path):
    def fail_at_two(task):
        if task.seed == 2:
            raise ValueError("two")
        return draw(task)

    with pytest.raises(ValueError, match="two"):
        keep(Plan(tmp_path), fail_at_two, [Draw(i) for i in range(4)], "Drawing")
    assert keep(Plan(tmp_path), draw, [Draw(i) for i in range(4)], "Drawing")
    assert [task.seed for task in calls] == [0, 1, 2, 3]


@pytest.mark.skipif(os.name == "nt", reason="kills a group of processes")
def test_a_killed_study_loses_the_runs_in_flight_alone(tmp_path):
    script = tmp_path / "study.py"
    script.write_text(SLOW)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
    study = subprocess.Popen([sys.executable, script, tmp_path], env=environment, start_new_session=True)
    runs = tmp_path / "runs"
    while study.poll() is None and not (runs.is_dir() and len(list(runs.glob("*.json"))) >= 2):
        time.sleep(0.02)
    os.killpg(study.pid, signal.SIGKILL)
    study.wait()
    finished = {path: path.stat().st_mtime_ns for path in runs.glob("*.json")}
    assert 2 <= len(finished) < 6
    numbers = [r["number"] for r in keep(Plan(tmp_path), draw, [Draw(i) for i in range(6)], "Drawing")]
    assert numbers == [np.random.default_rng(i).normal() for i in range(6)]
    assert len(calls) == 6 - len(finished)
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
