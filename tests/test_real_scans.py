"""Real scans, end to end; skipped with a reason where they are absent."""

import numpy as np
import pytest

from processing.batch import Job, process_recording
from processing.results.files import read_results
from recorder import mcap_file
from recorder.sources import open_capture


def convert(source, folder):
    sessions = open_capture(source)
    for session in sessions:
        mcap_file.write(session, folder / f"{session.info.name}.mcap")
    return {session.info.name: folder / f"{session.info.name}.mcap" for session in sessions}


@pytest.fixture(scope="module")
def bunny(data, tmp_path_factory):
    return next(iter(convert(data / "stanford_bunny", tmp_path_factory.mktemp("bunny")).values()))


def test_the_bunny_at_steps_of_45_degrees(bunny, tmp_path):
    outcome = process_recording(bunny, Job(tmp_path, views="0,1,2"))
    found = read_results(outcome.folder)["reconstruction"]
    ours = found["pairwise"]["pairs"]
    assert [(pair["source"], pair["target"]) for pair in ours] == [(1, 0), (2, 1)]
    for pair in ours:
        assert pair["status"] == "ok"
        assert pair["rotation_error_deg"] < 1.5
        assert pair["center_error_m"] < 0.002
    for error in ("rotation_error_deg", "center_error_m"):
        median = {method: np.median([pair[error] for pair in found[method]["pairs"]]) for method in found}
        assert median["icp"] > 5 * median["pairwise"]


def test_no_pair_of_the_bunny_that_is_called_ok_is_wrong(bunny, tmp_path):
    outcome = process_recording(bunny, Job(tmp_path, views="all", methods=("pairwise",)))
    pairs = read_results(outcome.folder)["reconstruction"]["pairwise"]["pairs"]
    called_ok = [pair for pair in pairs if pair["status"] == "ok"]
    assert len(called_ok) >= 4
    for pair in called_ok:
        assert pair["rotation_error_deg"] < 5
        assert pair["center_error_m"] < 0.01


def test_a_kinect_circle_without_truth(data, tmp_path):
    recordings = convert(data / "washington" / "rgbd-dataset", tmp_path)
    assert set(recordings) >= {"cap_1_1", "bell_pepper_1_1", "coffee_mug_2_1", "soda_can_2_1"}
    outcome = process_recording(recordings["cap_1_1"], Job(tmp_path / "out", views="36", methods=("pairwise",)))
    found = read_results(outcome.folder)
    views = found["reconstruction"]["pairwise"]["views"]
    assert len(views) == 36
    assert {view["translation_error_m"] for view in views} == {None}
    assert sum(view["status"] == "ok" for view in views) >= 34
    assert found["model"]["points"] > 10_000
