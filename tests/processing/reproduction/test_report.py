"""A report's files hold its numbers, and are the same to the byte each time."""

import csv
import json

import numpy as np
import pytest

from orbitscan.processing.reproduction import charts
from orbitscan.processing.reproduction.claims import Claim, compare
from orbitscan.processing.reproduction.plan import Plan
from orbitscan.processing.reproduction.report import Report, read, write
from orbitscan.recorder.exceptions import InvalidOption, UnwritableOutput

ROWS = [{"name": "a", "loss": 0.5, "thesis_loss": None}, {"name": "b", "loss": 0.25, "thesis_loss": 0.3}]

CLAIMS = [
    compare("b is better than a: truly", [2, 3, 4], [1, 1, 1], "points"),
    compare("a is quick", [1], [2], "s"),
    Claim("nobody knows", "cannot be told", missing="no view"),
]


def make():
    figure, ((axes,),) = charts.new_figure()
    charts.draw_boxes(axes, {"a": [1, 2, 3], "b": np.arange(10)}, "loss [nats]")
    return Report("table-0.1", "A table", ROWS, ["It is so."], CLAIMS, {"figure-0.1": figure}, {"epochs": 2})


def test_the_numbers_are_read_back(tmp_path):
    paths = write(make(), Plan(tmp_path, runs=3, fraction=0.5), "orbitscan reproduce table-0.1")
    assert sorted(path.name for path in paths) == sorted(path.name for path in tmp_path.iterdir())
    with (tmp_path / "table-0.1.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["name"], float(row["loss"]), row["thesis_loss"]) for row in rows] == [
        ("a", 0.5, ""),
        ("b", 0.25, "0.3"),
    ]
    content = json.loads((tmp_path / "table-0.1.json").read_text())
    assert content["rows"] == ROWS
    assert (content["seeds"], content["fraction"], content["settings"]) == ([0, 1, 2], 0.5, {"epochs": 2})
    assert content["versions"].keys() >= {"orbitscan", "torch"}
    assert content["machine"]["cores"] >= 1


def test_a_report_is_read_back_with_its_claims(tmp_path):
    write(make(), Plan(tmp_path), "orbitscan reproduce table-0.1")
    found = read(tmp_path / "table-0.1.json")
    assert found.claims == CLAIMS
    assert (found.said, found.rows) == (["It is so."], ROWS)


def test_a_report_of_an_earlier_version_is_refused(tmp_path):
    write(make(), Plan(tmp_path), "orbitscan reproduce table-0.1")
    path = tmp_path / "table-0.1.json"
    content = json.loads(path.read_text())
    path.write_text(json.dumps(content | {"format_version": 1}))
    with pytest.raises(InvalidOption, match=r"table-0\.1\.json: is no report of this version; make it again"):
        read(path)


def test_the_same_numbers_make_the_same_bytes(tmp_path):
    contents = []
    for _ in range(2):
        paths = write(make(), Plan(tmp_path), "orbitscan reproduce table-0.1")
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]


def test_a_place_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UnwritableOutput, match="choose another place"):
        write(make(), Plan(tmp_path / "file"), "orbitscan")
