"""The commands `view` and `compare`: what they open, print and exit with."""

import json

import pytest

from orbitscan.processing.batch.recording import Job, process_recording
from orbitscan.recorder import mcap_file
from tests.command import run
from tests.geometry import scan
from tests.processing.results.comparison.test_compare import change, copy
from tests.viewer import find_reports, open_viewer


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """Results of a session, in a batch's folder."""
    folder = tmp_path_factory.mktemp("done")
    mcap_file.write(scan(n_views=3, points=6000), folder / "blob.mcap")
    outcome = process_recording(folder / "blob.mcap", Job(folder / "out", model=None))
    assert outcome.status == "done", outcome.message
    return folder


@pytest.fixture
def stub(tmp_path):
    """In place of the viewer: it prints what it is given."""
    viewer = tmp_path / "rerun"
    viewer.write_text('#!/bin/sh\necho "$@"\nexit 3\n')
    viewer.chmod(0o755)
    return {"RERUN_CLI_PATH": str(viewer)}


def test_view_hands_what_there_is_to_the_viewer_and_its_exit_status_on(done, stub):
    review = "out/blob/review.rrd"
    for what, opened in (("out/blob", review), ("out", review), (review, review), ("blob.mcap", "blob.mcap")):
        finished = run("view", what, cwd=done, env=stub)
        assert (finished.stdout.strip(), finished.returncode) == (opened, 3), finished.stderr


@pytest.mark.parametrize("what", ["nowhere", ".", "out/blob/errors.csv"])
def test_what_cannot_be_viewed_is_told(done, what, tmp_path, stub):
    finished = run("view", tmp_path / what if what == "." else what, cwd=done, env=stub)
    assert finished.returncode == 2
    assert len(finished.stderr.splitlines()) == 1


def test_of_a_batch_the_summary_is_shown_and_the_worst_sessions_listed(done, tmp_path, stub):
    for name, failed in (("fine", 0), ("worst", 2), ("worse", 1)):
        copy(done / "out" / "blob", tmp_path / "batch" / name)
        change(
            tmp_path / "batch" / name,
            lambda r, n=failed: r["reconstruction"]["refined"]["summary"].update(failed_views=n),
        )
    (tmp_path / "batch" / "summary.rrd").touch()
    finished = run("view", "batch", "--most", "2", cwd=tmp_path, env=stub)
    assert "1 better session is left out: --most 3 opens all" in finished.stdout
    opened = finished.stdout.splitlines()[-1].split()  # the last one is in front
    assert opened == ["batch/worse/review.rrd", "batch/worst/review.rrd", "batch/summary.rrd"]


@pytest.mark.usefixtures("renderer")
def test_a_screenshot_needs_no_display(done, tmp_path):
    picture = tmp_path / "blob.png"
    finished = run("view", "out/blob", "--screenshot", picture, "--at", "1", "--size", "800x500", cwd=done)
    assert finished.returncode == 0, finished.stderr
    assert "no view complains" in finished.stdout
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert [path.name for path in tmp_path.iterdir()] == ["blob.png"]


def test_a_cut_review_is_told_in_a_sentence_and_leaves_no_picture(done, tmp_path):
    whole = (done / "out" / "blob" / "review.rrd").read_bytes()
    (tmp_path / "cut.rrd").write_bytes(whole[: len(whole) // 2])
    for options in ([], ["--at", "1"]):
        finished = run("view", "cut.rrd", "--screenshot", "cut.png", *options, cwd=tmp_path)
        assert finished.returncode == 2
        (line,) = finished.stderr.splitlines()
        assert "cut.rrd" in line or "mesa-vulkan-drivers" in line
    assert [path.name for path in tmp_path.iterdir()] == ["cut.rrd"]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--at", "1"], "is for pictures"),
        (["--screenshot", "blob.jpg"], "a picture is a PNG"),
        (["--screenshot", "nowhere/blob.png"], "its folder does not exist"),
        (["--screenshot", "blob.png", "--size", "big"], "not the size of a picture"),
        (["--screenshot", "blob.png", "--at", "9"], "there are 0 to 2"),
    ],
)
def test_wrong_options_of_view(done, options, says):
    finished = run("view", "out/blob", *options, cwd=done)
    assert finished.returncode == 2
    assert says in finished.stderr


@pytest.fixture(scope="module")
def worse(done, tmp_path_factory):
    """A folder with results `b` of which a view failed, and the comparison `changes.rrd` with them."""
    folder = tmp_path_factory.mktemp("worse")
    copy(done / "out" / "blob", folder / "b")

    def fail(results):
        results["reconstruction"]["refined"]["views"][2]["status"] = "low_overlap"

    change(folder / "b", fail)
    return folder, run("compare", done / "out" / "blob", "b", "--rrd", "changes.rrd", cwd=folder)


def test_compare_exits_with_1_where_b_is_worse(done, worse):
    folder, finished = worse
    assert finished.returncode == 1
    assert "B is worse in 1 of 3 views by refined" in finished.stdout
    assert "low_overlap" in finished.stdout
    told = json.loads(run("compare", done / "out" / "blob", "b", "--json", cwd=folder).stdout)
    assert told["is_worse"]
    assert told["sessions"][0]["verdict"] == "worse"
    better = run("compare", "b", done / "out" / "blob", cwd=folder)
    assert (better.returncode, "nowhere worse; better in 1 of 3 views" in better.stdout) == (0, True)


def test_compare_exits_with_0_where_nothing_changed(done, tmp_path):
    copy(done / "out" / "blob", tmp_path / "b")
    assert run("compare", done / "out" / "blob", "b", cwd=tmp_path).returncode == 0


@pytest.mark.usefixtures("renderer")
def test_what_compare_writes_opens_without_a_complaint(worse):
    folder, _ = worse
    with open_viewer(folder / "changes.rrd") as viewer:
        assert len(viewer.get_state().views) == 7
        assert find_reports(viewer) == []


def test_of_two_batches_the_worst_views_are_printed_whole_on_a_narrow_terminal(done, tmp_path):
    def spoil(results):
        for view in results["reconstruction"]["refined"]["views"][1:]:
            view["center_error_m"] += 0.1

    for name in ("a/one", "a/two", "b/one", "b/two"):
        copy(done / "out" / "blob", tmp_path / name)
    change(tmp_path / "b" / "two", spoil)
    finished = run("compare", "a", "b", "--rrd", "c.rrd", cwd=tmp_path, env={"COLUMNS": "80"})
    assert finished.returncode == 1
    assert finished.stdout.startswith("B is worse in 1 of 2 sessions: two.")
    (row,) = (
        line for line in finished.stdout.splitlines() if line.startswith(" two") and " 1 " in line and "ok" in line
    )
    assert row.split()[:5] == ["two", "1", "refined", "worse", "ok"]
    assert "centre" in row
    assert float(row.split()[-1]) > 10  # floors
    assert (tmp_path / "c.rrd").is_file()


def test_compare_of_what_holds_no_results(done, tmp_path):
    (tmp_path / "empty").mkdir()
    for b in ("empty", "nowhere", done / "blob.mcap"):
        finished = run("compare", done / "out" / "blob", b, cwd=tmp_path)
        assert finished.returncode == 2
        assert len(finished.stderr.splitlines()) == 1
    mixed = run("compare", done / "out" / "blob", done / "out", cwd=tmp_path)
    assert (mixed.returncode, "name two of a kind" in mixed.stderr) == (2, True)
