"""What changed between two results, and whether that is more than the views' own evidence allows."""

import json
import shutil

import numpy as np
import pytest

from orbitscan.processing.batch.recording import Job, process_recording
from orbitscan.processing.results.comparison.compare import compare_folders
from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import InvalidOption, UnreadableRecording
from tests.geometry import scan


def copy(folder, to):
    """Results without the recordings, which nothing here looks at."""
    shutil.copytree(folder, to, ignore=shutil.ignore_patterns("*.mcap"))


def change(folder, how):
    """Edit a results.json."""
    path = folder / "results.json"
    results = json.loads(path.read_text())
    how(results)
    path.write_text(json.dumps(results))


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("done")
    mcap_file.write(scan(n_views=3), folder / "blob.mcap")
    process_recording(folder / "blob.mcap", Job(folder / "out", model=None))
    return folder


@pytest.fixture
def pair(done, tmp_path):
    """A and B: the same, until B is changed."""
    copy(done / "out" / "blob", tmp_path / "b")
    return done / "out" / "blob", tmp_path / "b"


def compare(pair):
    return compare_folders(*pair).sessions[0]


def of_view(session, view, method="refined"):
    (found,) = (v for v in session.views if (v.view, v.method) == (view, method))
    return found


def shift(results, view, metres, method="refined"):
    """Move a view's error and its pose by as much."""
    found = results["reconstruction"][method]["views"][view]
    found["center_error_m"] += metres
    found["translation_error_m"] += metres
    found["T_0_i"][0][3] += metres


def test_the_same_results_are_identical(pair):
    session = compare(pair)
    assert (session.identical, session.verdict, session.changed_views) == (True, "same", [])


def test_an_error_counts_from_the_floor_on_and_alike_in_both_directions(pair):
    change(pair[1], lambda results: results.update(seed=1))
    floor = of_view(compare(pair), 2).errors["center_error_m"].floor
    for factor, there, back in ((0.5, "same", "same"), (1.5, "worse", "better"), (100, "worse", "better")):
        change(pair[1], lambda results, f=factor: shift(results, 2, f * floor))
        assert of_view(compare(pair), 2).verdict == there, factor
        assert of_view(compare(pair[::-1]), 2).verdict == back, factor
        assert of_view(compare(pair), 1).verdict == "same"
        change(pair[1], lambda results, f=factor: shift(results, 2, -f * floor))


def test_floors_are_alike_in_both_directions(pair):
    change(pair[1], lambda results: results.update(seed=1))
    floor = of_view(compare(pair), 2).floor_m
    change(pair[1], lambda results: shift(results, 2, -100 * floor))  # far nearer to the object, or farther from it
    there, back = (of_view(compare(folders), 2) for folders in (pair, pair[::-1]))
    assert there.size > 10
    assert (there.floor_m, there.size, there.moved_m) == pytest.approx((back.floor_m, back.size, back.moved_m))
    assert [e.floor for e in there.errors.values()] == pytest.approx([e.floor for e in back.errors.values()])


def test_a_pose_is_worse_only_beyond_both_bounds(pair, tmp_path):
    copy(pair[0], tmp_path / "a")
    folders = tmp_path / "a", pair[1]

    def bound(results, metres):
        for view in results["reconstruction"]["refined"]["views"]:
            view.update(rotation_bound_deg=2.0, center_bound_m=metres)

    for folder in folders:
        change(folder, lambda results: bound(results, 0.01))
    for metres, verdict in ((0.015, "same"), (0.01, "worse")):  # in all 25 mm, farther than 20 mm
        change(folders[1], lambda results, m=metres: shift(results, 2, m))
        found = of_view(compare(folders), 2)
        assert (found.floor_m, found.verdict) == (pytest.approx(0.02), verdict)
    change(folders[1], lambda results: bound(results, None))
    assert of_view(compare(folders), 2).floor_m < 0.02  # where one does not tell, the overlap does


def test_the_floor_is_what_other_noise_moves_the_poses_by(done, tmp_path):
    """Five scans of one object, each with other noise: errors differ by chance, at most once in twenty beyond it."""
    for seed in range(5):
        mcap_file.write(scan(n_views=3, seed=seed), tmp_path / f"{seed}" / "blob.mcap")
        job = Job(tmp_path / "out" / f"{seed}", methods=("pairwise",), model=None)
        process_recording(tmp_path / f"{seed}" / "blob.mcap", job)
    folders = sorted((tmp_path / "out").glob("*/blob"))
    views = [
        view
        for i, a in enumerate(folders)
        for b in folders[i + 1 :]
        for view in compare_folders(a, b).sessions[0].views
        if view.view > 0
    ]
    sizes = np.array([view.size for view in views])
    assert len(sizes) == 20
    assert (sizes > 1).mean() <= 0.2  # three errors a view; ten pairs of five scans are not independent
    assert sizes.max() > 0.1  # and no floor that nothing exceeds


def test_statuses_are_worth_what_they_claim(pair):
    def set_status(status, error=None):
        def edit(results):
            view = results["reconstruction"]["pairwise"]["views"][1]
            view["status"] = status
            view["center_error_m"] = view["center_error_m"] if error is None else error

        change(pair[1], edit)

    for status, error, verdict in (("ambiguous", None, "worse"), ("low_overlap", None, "worse")):
        set_status(status, error)
        assert of_view(compare(pair), 1, "pairwise").verdict == verdict
        assert of_view(compare(pair[::-1]), 1, "pairwise").verdict == "better"
    wrong = pair[0].parent / "wrong"
    shutil.rmtree(wrong, ignore_errors=True)
    copy(pair[0], wrong)
    change(wrong, lambda r: r["reconstruction"]["pairwise"]["views"][1].update(center_error_m=1.0))
    assert of_view(compare((wrong, pair[1])), 1, "pairwise").verdict == "better"  # it says at least that it failed
    shutil.rmtree(wrong)


def forget(results):
    """Take out what only the truth tells."""
    for method in results["reconstruction"].values():
        for entry in (*method["views"], *method["pairs"]):
            entry.update({key: None for key in entry if "error" in key})


def test_without_truth_a_motion_is_neither_better_nor_worse(pair):
    copy(pair[0], pair[1].parent / "a")
    untrue = (pair[1].parent / "a", pair[1])
    for folder in untrue:
        change(folder, forget)
    assert compare(untrue).identical
    change(untrue[1], lambda r: r["reconstruction"]["refined"]["views"][2]["T_0_i"][0].__setitem__(3, 0.5))
    found = of_view(compare(untrue), 2)
    assert (found.verdict, found.errors) == ("changed", {})
    assert found.moved_m > 0.01
    assert not compare_folders(*untrue).is_worse


def test_in_another_recording_no_camera_has_moved(pair, tmp_path):
    copy(pair[0], tmp_path / "a")
    for folder in (tmp_path / "a", pair[1]):
        change(folder, forget)
    change(pair[1], lambda r: r["reconstruction"]["refined"]["views"][2]["T_0_i"][0].__setitem__(3, 0.5))
    change(pair[1], lambda r: r["input"].update(sha256="another"))
    session = compare((tmp_path / "a", pair[1]))
    assert (session.verdict, of_view(session, 2).moved_m) == ("same", None)
    assert any("another recording" in note for note in session.notes)
    change(pair[1], lambda r: r["reconstruction"]["refined"]["views"][2].update(status="low_overlap"))
    assert of_view(compare((tmp_path / "a", pair[1])), 2).verdict == "worse"


def test_sessions_of_batches_are_matched_by_name(done, tmp_path):
    for name in ("a/one", "a/two", "a/lost", "b/one", "b/two", "b/new"):
        copy(done / "out" / "blob", tmp_path / name)
    change(tmp_path / "b" / "two", lambda r: r["reconstruction"]["refined"]["views"][1].update(status="diverged"))
    found = compare_folders(tmp_path / "a", tmp_path / "b")
    assert [session.verdict for session in found.sessions] == ["worse", "same"]
    assert (found.only_a, found.only_b) == (("lost",), ("new",))
    assert found.is_worse
    assert not compare_folders(tmp_path / "b" / "one", tmp_path / "a" / "one").is_worse


def test_what_cannot_be_compared(done, pair, tmp_path):
    with pytest.raises(InvalidOption, match="two of a kind"):
        compare_folders(pair[0], done / "out")
    change(pair[1], lambda results: results.update(reconstruction={}))
    with pytest.raises(InvalidOption, match="no view by a method"):
        compare_folders(*pair)
    (pair[1] / "results.json").write_text("{")
    with pytest.raises(UnreadableRecording, match="holds no whole results"):
        compare_folders(*pair)
    change_to_nothing = tmp_path / "nothing"
    change_to_nothing.mkdir()
    with pytest.raises(InvalidOption, match="holds no results"):
        compare_folders(pair[0], change_to_nothing)
