"""Two results side by side: one recording that opens without a complaint, whole or not at all."""

import subprocess

import pytest
from rerun.chunk import RrdReader

from orbitscan.processing.batch.recording import Job, process_recording
from orbitscan.processing.results.comparison.compare import compare_folders
from orbitscan.processing.results.status import Status
from orbitscan.processing.review.comparison import recording
from orbitscan.processing.review.comparison.recording import write_comparison
from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import UnwritableOutput
from tests import viewer
from tests.geometry import scan
from tests.processing.results.comparison.test_compare import change, copy


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Results of a scan."""
    folder = tmp_path_factory.mktemp("done")
    mcap_file.write(scan(n_views=3), folder / "blob.mcap")
    outcome = process_recording(folder / "blob.mcap", Job(folder / "out", methods=("icp", "pairwise"), model=None))
    assert outcome.status == "done", outcome.message
    return folder / "out" / "blob"


def fail(folder, view):
    change(folder, lambda r: r["reconstruction"]["pairwise"]["views"][view].update(status=Status.LOW_OVERLAP))


def forget(folder):
    """Take the ground truth away."""

    def edit(results):
        for method in results["reconstruction"].values():
            for entry in (*method["views"], *method["pairs"]):
                entry.update({key: None for key in entry if "error" in key})

    change(folder, edit)


def entities_of(path):
    return {chunk.entity_path for chunk in RrdReader(path).stream()}


def write(path, a, b):
    write_comparison(path, compare_folders(a, b), a, b)
    return entities_of(path)


def test_both_models_and_the_errors_of_both_are_in_it(done, tmp_path):
    copy(done, tmp_path / "b")
    fail(tmp_path / "b", 2)
    found = write(tmp_path / "changes.rrd", done, tmp_path / "b")
    for side in ("a", "b"):
        assert f"/blob/model/{side}" in found
        for method in ("icp", "pairwise"):
            assert f"/blob/errors/center_mm/{method}_{side}" in found


def test_the_same_comparison_is_the_same_recording(done, tmp_path):
    copy(done, tmp_path / "b")

    def differ(a, b):
        for folder in ("one", "two"):
            (tmp_path / folder).mkdir(exist_ok=True)
        write(tmp_path / "one" / "changes.rrd", done, a)
        write(tmp_path / "two" / "changes.rrd", done, b)
        recordings = (tmp_path / folder / "changes.rrd" for folder in ("one", "two"))
        return subprocess.run([viewer.RERUN, "rrd", "compare", *recordings], capture_output=True).returncode

    assert differ(tmp_path / "b", tmp_path / "b") == 0
    copy(tmp_path / "b", tmp_path / "c")
    fail(tmp_path / "c", 2)
    assert differ(tmp_path / "b", tmp_path / "c") == 1


@pytest.mark.parametrize(("most", "shown"), [(2, {"worst", "bad"}), (9, {"worst", "bad", "less"})])
def test_of_a_batch_the_worst_sessions_that_changed_are_shown(done, tmp_path, monkeypatch, most, shown):
    monkeypatch.setattr(recording, "SHOWN_SESSIONS", most)
    for name, failed in (("bad", 1), ("fine", 0), ("less", 1), ("worst", 2)):
        copy(done, tmp_path / "a" / name)
        copy(done, tmp_path / "b" / name)
        for folder in (tmp_path / "a", tmp_path / "b"):
            change(folder / name, lambda r, name=name: r["session"].update(name=name))
        for view in range(1, 1 + failed):
            fail(tmp_path / "b" / name, view)
    found = write(tmp_path / "changes.rrd", tmp_path / "a", tmp_path / "b")
    assert {path.split("/")[1] for path in found if "/model/" in path} == shown


@pytest.mark.parametrize(
    ("kind", "views"),  # two models, words, plots of three errors and of the motion; of a batch the summary too
    [("changed", 7), ("without truth", 4), ("batch", 8), ("nothing changed in a batch", 1)],
)
@pytest.mark.usefixtures("renderer")
def test_it_opens_without_a_complaint(done, tmp_path, kind, views):
    inside = "blob" if "batch" in kind else ""
    for side in ("a", "b"):
        copy(done, tmp_path / side / inside)
        if kind == "without truth":
            forget(tmp_path / side / inside)
    if kind != "nothing changed in a batch":
        fail(tmp_path / "b" / inside, 1)
    write(tmp_path / "changes.rrd", tmp_path / "a", tmp_path / "b")
    with viewer.open_viewer(tmp_path / "changes.rrd") as client:
        assert len(client.get_state().views) == views
        assert viewer.find_reports(client) == []


def test_where_it_cannot_be_written_nothing_is_left(done, tmp_path):
    (tmp_path / "changes.rrd").mkdir()
    (tmp_path / "file").touch()
    with pytest.raises(UnwritableOutput):
        write(tmp_path / "changes.rrd", done, done)
    with pytest.raises(UnwritableOutput):
        write(tmp_path / "file" / "changes.rrd", done, done)
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["changes.rrd", "file"]
