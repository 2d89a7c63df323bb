"""The command `reproduce`: what it writes, prints and refuses."""

import json
from importlib import import_module

import pytest

from orbitscan.processing.reproduction import STUDIES, find
from orbitscan.processing.reproduction.claims import compare
from orbitscan.processing.reproduction.report import Report
from orbitscan.recorder.exceptions import InvalidOption
from tests.command import run


@pytest.fixture
def orbitscan(tmp_path):
    """Runs the command in an empty folder: status, output, complaints."""

    def run_there(*arguments):
        finished = run(*arguments, cwd=tmp_path)
        return finished.returncode, finished.stdout, finished.stderr

    return run_there


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_is_a_function_with_a_word_on_it(name):
    module, _, function = STUDIES[name].rpartition(".")
    assert find(name) is getattr(import_module(f"orbitscan.processing.reproduction.{module}"), function)
    assert find(name).__doc__


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["table-9.9"], "table-9.9: no table or figure of the thesis; choose all, or one of gallery, figure-3.5"),
        (["table-5.1", "--fraction", "0"], "--fraction 0: "),
        (["table-5.1", "--fraction", "2"], "--fraction 2: "),
        (["table-5.1", "--runs", "0"], "--runs 0: "),
        (["table-5.1", "--device", "cuda:99"], "--device cuda:99: "),
        (["table-5.1", "--dataset", "nowhere"], "nowhere: no such folder; "),
    ],
)
def test_wrong_input_is_one_sentence(orbitscan, tmp_path, arguments, said):
    status, out, err = orbitscan("reproduce", *arguments, "-o", "out")
    assert (status, out) == (2, "")
    (line,) = [line for line in err.splitlines() if not line.startswith("Compiling")]
    assert line.removeprefix("orbitscan: error: ").startswith(said)
    assert not (tmp_path / "out").exists()


def test_a_study_is_printed_and_its_files_are_named(orbitscan, tmp_path):
    status, out, _ = orbitscan("reproduce", "table-5.2", "-o", "out")
    assert status == 0
    assert out.startswith("table-5.2: ")
    content = json.loads((tmp_path / "out" / "table-5.2.json").read_text())
    assert content["command"] == "orbitscan reproduce table-5.2 -o out"
    assert all(sentence in out for sentence in content["said"])
    assert content["claims"] == []
    assert all((tmp_path / name).is_file() for name in out.split("See ")[1].strip().split(", "))


def test_a_study_that_fails_does_not_stop_the_others(orbitscan, tmp_path, monkeypatch):
    def fail(plan):
        raise InvalidOption("here", "goes nothing", "go elsewhere")

    def succeed(plan):
        return Report("table-5.2", "A table", [{"a": 1}], ["Said."], [compare("A is larger", [1], [0], "points")])

    monkeypatch.setattr("orbitscan.processing.cli.reproduce.STUDIES", {"gallery": "", "table-5.2": ""})
    monkeypatch.setattr("orbitscan.processing.cli.reproduce.find", {"gallery": fail, "table-5.2": succeed}.__getitem__)
    status, out, err = orbitscan("reproduce", "all", "-o", "out")
    assert status == 1
    assert err.splitlines()[-1] == "gallery: here: goes nothing; go elsewhere"
    assert "Said.\nA is larger: cannot be told (difference +1 points in one run, too few for an interval).\n" in out
    assert "Look at it all: out/index.html" in out
    assert (tmp_path / "out" / "reproduction.rrd").is_file()


def test_many_rows_are_cut_and_unknown_values_are_dashes(orbitscan, monkeypatch):
    rows = [{"step": i, "loss": None} for i in range(50)]
    monkeypatch.setattr(
        "orbitscan.processing.cli.reproduce.find", lambda name: lambda plan: Report(name, "Steps", rows)
    )
    _, out, _ = orbitscan("reproduce", "table-5.2", "-o", "out")
    assert "... 10 more rows in table-5.2.csv" in out
    assert out.count(" -") == 40
