"""A results folder reads back as what was written, and what is none is told in a sentence."""

import csv
import json
import math
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.processing.results.folder import FORMAT_VERSION, Extent, Results, read_results, to_json, write_results
from orbitscan.processing.results.key import read_key
from orbitscan.processing.results.records import Coverage, Gap
from orbitscan.processing.results.status import Method
from orbitscan.recorder.exceptions import UnreadableRecording
from tests.processing.review.made_results import BOUND_DEG, BOUND_M, FAILED, make_results, true_poses

KEY = {"orbitscan": "0", "input_sha256": "ab", "views": "all"}
LEFT_OUT = {"information", "center", "covariance"}  # of a pair: results.json does not hold them


def plain(record):
    """A record in lists and mappings, but for what results.json leaves out."""
    if isinstance(record, dict):
        return {key: plain(value) for key, value in record.items() if key not in LEFT_OUT}
    if isinstance(record, list | tuple):
        return [plain(value) for value in record]
    return record.tolist() if isinstance(record, np.ndarray) else record


@pytest.fixture
def written(tmp_path):
    session = make_results()[1]
    gaps = (Gap(10.0, 70.0, 1, 2),)
    coverage = Coverage(np.array([0, -1.0, 0]), np.zeros(3), np.array([1.0, 0, 0]), {1: 10.0, 2: 70.0}, gaps)
    session = replace(session, coverage=coverage)
    results = Results.of(session, KEY, "sphere.mcap", "cut at its end")
    write_results(tmp_path, session, results, true_poses(5))
    return tmp_path, results, session


def test_what_is_read_is_what_was_written(written):
    folder, results, session = written
    found = read_results(folder)
    assert plain(asdict(found.results.reconstruction["refined"])) == plain(asdict(results.reconstruction["refined"]))
    assert plain(asdict(found.results)["turntable"]) == plain(asdict(session.turntable))
    assert found.results.coverage.azimuths_deg == {1: 10.0, 2: 70.0}
    assert found.results.coverage.gaps == session.coverage.gaps
    assert found.results.input.damage == "cut at its end"
    assert json.loads(json.dumps(to_json(found.results))) == json.loads((folder / "results.json").read_text())
    np.testing.assert_allclose(found.model[0], session.model.points)
    assert found.seconds == {"total": 1.5}
    assert found.results.best.loop_closed


def test_errors_stand_beside_what_they_are_of(written):
    view = json.loads((written[0] / "results.json").read_text())["reconstruction"]["refined"]["views"][1]
    assert set(view) == {
        "view", "status", "T_0_i", "pair", "component", "T_component_i", "rotation_bound_deg", "center_bound_m", "note",
        "translation_error_m", "rotation_error_chordal", "rotation_error_deg", "center_error_m",
    }  # fmt: skip


def test_bounds_stand_at_the_end_of_the_errors(written):
    with (written[0] / "errors.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0])[-3:] == ["center_error_m", "rotation_bound_deg", "center_bound_m"]
    bounds = {row["view"]: (row["rotation_bound_deg"], row["center_bound_m"]) for row in rows[-5:]}
    assert bounds["1"] == (str(BOUND_DEG), str(BOUND_M))
    assert bounds[str(FAILED)] == ("", "")  # nobody can tell


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers(0, 10**6))
def test_every_number_comes_back_to_the_last_bit(value, view):
    session = make_results(points=50)[1]
    refined = session.reconstruction["refined"]
    first = replace(refined.views[0], view=view, errors=replace(refined.views[0].errors, center_error_m=value))
    changed = replace(refined, views=(first, *refined.views[1:]))
    results = Results.of(replace(session, reconstruction={Method.REFINED: changed}), KEY, "", None)
    text = json.dumps(to_json(results))
    assert json.loads(text)["reconstruction"]["refined"]["views"][0]["center_error_m"] == value


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda content: content.update(format_version=1), f"format_version 1, not {FORMAT_VERSION}"),
        (lambda content: content.pop("session"), "session"),
        (lambda content: content["reconstruction"].update(magic={}), "reconstruction.magic"),
        (lambda content: content["reconstruction"]["icp"]["views"][0].update(status="fine"), "views.0.*status"),
    ],
)
def test_what_results_json_should_not_say_is_told(written, damage, says):
    path = written[0] / "results.json"
    content = json.loads(path.read_text())
    damage(content)
    path.write_text(json.dumps(content))
    with pytest.raises(UnreadableRecording, match=rf"holds no whole results \(.*{says}.*make it again"):
        read_results(written[0])
    assert read_key(written[0]) == KEY  # made by an earlier version they are made again, not in the way


def test_a_folder_without_results_has_no_key(tmp_path):
    assert read_key(tmp_path) is None
    with pytest.raises(UnreadableRecording, match="No such file"):
        read_results(tmp_path)


def test_an_extent_is_that_of_the_points_but_for_stray_ones():
    rng = np.random.default_rng(1)
    ball = rng.normal(size=(20000, 3))
    ball *= 0.1 / np.linalg.norm(ball, axis=1, keepdims=True)
    ball[:, 2] += 1
    found = Extent.of(np.vstack([ball, [[0, 0, 9]]]))
    assert found.center == pytest.approx([0, 0, 1], abs=3e-3)
    assert found.diameter == pytest.approx(0.2 * math.sqrt(3), rel=0.05)
    assert found.lever == pytest.approx(0.1, rel=0.2)
    assert Extent.of(np.zeros((1, 3))).lever > 0
