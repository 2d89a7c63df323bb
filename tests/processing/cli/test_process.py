"""The real command, from a recording to results: what it prints, writes and exits with."""

import csv
import hashlib
import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

from orbitscan.processing.batch.recording import Job, process_recording
from orbitscan.processing.classification import PACKAGED
from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import UnreadableRecording
from orbitscan.recorder.formats import ply
from orbitscan.recorder.session import in_memory
from orbitscan.recorder.simulation.objects import CATEGORIES
from tests.command import run, start
from tests.geometry import bottle, scan
from tests.viewer import RERUN, find_reports, open_viewer

POINTS = 16_000  # of an object: with fewer its ransac_icp places no view
QUICK = ("--methods", "pairwise", "--model", "none")


def results(folder):
    return json.loads((folder / "results.json").read_text())


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A recording of five views, processed; to look at, not to change."""
    folder = tmp_path_factory.mktemp("done")
    mcap_file.write(scan(n_views=5, points=POINTS), folder / "blob.mcap")
    return folder, run("process", "blob.mcap", "-o", "out", cwd=folder)


def test_process_writes_the_whole_folder_and_says_how_to_go_on(done):
    folder, finished = done
    assert finished.returncode == 0, finished.stderr
    methods = ("icp", "ransac_icp", "pairwise", "refined")
    assert {path.name for path in (folder / "out" / "blob").iterdir()} == {
        "review.rrd", "results.json", "timings.json", "errors.csv", "model.ply", "poses_truth.tum",
        "registered.mcap", "registered.foxglove.json",
        *(f"poses_{method}.tum" for method in methods),
    }  # fmt: skip
    assert [path.name for path in (folder / "out").iterdir()] == ["blob"]
    assert "pairwise" in finished.stdout
    assert finished.stdout.rstrip().endswith("orbitscan view out/blob")


def test_results_hold_what_the_format_says(done):
    folder, _ = done
    found = results(folder / "out" / "blob")
    assert list(found) == [
        "format_version", "key", "session", "input", "settings", "versions", "seed", "classification",
        "origin", "reconstruction", "turntable", "coverage", "model", "model_apart",
    ]  # fmt: skip
    assert found["session"]["views_used"] == [0, 1, 2, 3, 4]
    assert found["input"]["damage"] is None
    pairwise = found["reconstruction"]["pairwise"]
    assert [view["status"] for view in pairwise["views"]] == ["ok"] * 5
    assert pairwise["summary"]["max_rotation_error_chordal"] < 0.01
    pair = pairwise["pairs"][0]
    assert (pair["source"], pair["target"]) == (1, 0)
    assert pair["candidates"]
    assert {candidate["start"].split()[0].strip(",") for candidate in pair["candidates"]} <= {
        "identity", "previous", "ransac", "consensus",
    }  # fmt: skip
    assert (pair["unobservable"], pair["alternatives"]) == ([], [])
    assert pair["rotation_error_deg_observable"] == pytest.approx(pair["rotation_error_deg"])
    refined = found["reconstruction"]["refined"]
    assert [view["status"] for view in refined["views"]] == ["ok"] * 5
    assert len(refined["pairs"]) > 4
    assert refined["unobservable"] == []
    assert found["turntable"]["step_deg"] == pytest.approx(20, abs=0.3)
    assert [deviation["view"] for deviation in found["turntable"]["deviations"]] == [0, 1, 2, 3, 4]
    assert found["model"]["method"] == "refined"
    assert np.shape(pair["T_target_source"]) == (4, 4)
    timings = json.loads((folder / "out" / "blob" / "timings.json").read_text())
    assert set(timings) == {"methods", "outlier_removal", "classification", "total"}
    assert 0 < timings["classification"] < timings["total"]
    assert timings["methods"]["icp"]["ransac"] == 0 < timings["methods"]["pairwise"]["refine"]


def test_results_hold_what_the_views_show(done):
    folder, _ = done
    found = results(folder / "out" / "blob")
    shown = found["classification"]
    assert shown["model"] == found["key"]["model_sha256"] == hashlib.sha256(PACKAGED.read_bytes()).hexdigest()
    assert shown["categories"] == list(CATEGORIES)
    assert [view["view"] for view in shown["views"]] == [0, 1, 2, 3, 4]
    assert len(shown["entropy"]) == len(shown["fused"]) == 5
    for answer in (shown, *shown["views"]):
        assert (answer["category"] is None) == (not answer["known"])
    for view in shown["views"]:
        assert list(view["probabilities"]) == shown["categories"]
        assert all(round(p, 4) == p for p in view["probabilities"].values())


def test_without_a_model_nothing_is_classified(tmp_path):
    mcap_file.write(scan(n_views=2, points=POINTS), tmp_path / "blob.mcap")
    finished = run("process", "blob.mcap", "-o", "out", "--methods", "icp", "--model", "none", cwd=tmp_path)
    assert finished.returncode == 0, finished.stderr
    found = results(tmp_path / "out" / "blob")
    assert (found["classification"], found["key"]["model_sha256"]) == (None, None)
    again = run("process", "blob.mcap", "-o", "out", "--methods", "icp", cwd=tmp_path)
    assert "done again: changed model sha256" in again.stdout
    missing = run("process", "blob.mcap", "-o", "out", "--model", "nothing.pt", cwd=tmp_path)
    assert missing.returncode == 2
    assert "--model nothing.pt: no such file; name a model of 'orbitscan train', or 'none'" in missing.stderr


def test_errors_csv_and_trajectories_are_those_of_the_results(done):
    folder, _ = done
    out = folder / "out" / "blob"
    found = results(out)["reconstruction"]
    with (out / "errors.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 20
    for row in rows:
        view = found[row["method"]]["views"][int(row["view"])]
        assert float(row["rotation_error_chordal"]) == view["rotation_error_chordal"]
        assert row["status"] == view["status"]
    stamps = {
        name: [line.split()[0] for line in (out / name).read_text().splitlines()]
        for name in os.listdir(out)
        if name.endswith(".tum")
    }
    assert len(set(map(tuple, stamps.values()))) == 1
    assert stamps["poses_truth.tum"][0] == "1.000000000"


def test_evo_reads_the_trajectories_and_agrees(done):
    folder, _ = done
    out = folder / "out" / "blob"
    evo = Path(sys.executable).with_name("evo_ape")
    found = subprocess.run(
        [evo, "tum", out / "poses_truth.tum", out / "poses_pairwise.tum"],
        env=os.environ | {"HOME": str(folder)}, capture_output=True, text=True,
    )  # fmt: skip
    assert found.returncode == 0, found.stderr
    largest = next(float(line.split()[1]) for line in found.stdout.splitlines() if line.split()[:1] == ["max"])
    expected = results(out)["reconstruction"]["pairwise"]["summary"]["max_translation_error_m"]
    assert largest == pytest.approx(expected, abs=2e-6)


def test_the_reviews_curves_are_those_of_the_results(done):
    folder, _ = done
    out = folder / "out" / "blob"
    found = results(out)["reconstruction"]
    names = {
        "translation_m": "translation_error_m",
        "rotation_chordal": "rotation_error_chordal",
        "center_m": "center_error_m",
    }
    for quantity, key in names.items():
        for method, content in found.items():
            curve = {}
            for chunk in RrdReader(out / "review.rrd").stream().filter(content=f"/errors/{quantity}/{method}"):
                batch = chunk.to_record_batch()
                if "Scalars:scalars" in batch.schema.names:
                    values = [cell[0] for cell in batch.column("Scalars:scalars").to_pylist()]
                    curve |= dict(zip(batch.column("view").to_pylist(), values, strict=True))
            assert curve == {view["view"]: view[key] for view in content["views"]}


def test_the_review_is_a_whole_recording(done):
    folder, _ = done
    review = folder / "out" / "blob" / "review.rrd"
    assert subprocess.run([RERUN, "rrd", "verify", review], capture_output=True).returncode == 0


@pytest.mark.usefixtures("renderer")
def test_the_review_and_the_recording_open_without_a_complaint(done):
    folder, _ = done
    for path in (folder / "out" / "blob" / "review.rrd", folder / "blob.mcap"):
        with open_viewer(path) as viewer:
            assert viewer.get_state().views, f"nothing is shown of {path.name}"
            assert find_reports(viewer) == []


def test_done_is_skipped_and_a_change_is_named(done, tmp_path):
    folder, _ = done
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    written = (tmp_path / "out" / "blob" / "results.json").stat().st_mtime_ns
    again = run("process", "blob.mcap", "-o", "out", cwd=tmp_path)
    assert "blob.mcap: already done" in again.stdout
    assert "pairwise" in again.stdout
    assert (tmp_path / "out" / "blob" / "results.json").stat().st_mtime_ns == written
    changed = run("process", "blob.mcap", "-o", "out", "--views", "2", cwd=tmp_path)
    assert "done again: changed views" in changed.stdout
    assert results(tmp_path / "out" / "blob")["session"]["views_used"] == [0, 2]


def test_workers_threads_and_repetition_do_not_change_a_byte(tmp_path):
    """Two workers, whose kernels have a thread each and whose matrices two; and this process, where it is otherwise."""
    for name, seed in (("blob", 0), ("second", 1)):
        mcap_file.write(scan(n_views=2, points=8000, seed=seed), tmp_path / f"{name}.mcap")
    environment = dict.fromkeys(("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "2")
    batch = ("process", "blob.mcap", "second.mcap", "-o", "batch", "--workers", "2")
    finished = start(*batch, cwd=tmp_path, env=environment)
    assert finished.returncode == 0, finished.stderr
    for name in ("blob", "second"):
        assert run("process", f"{name}.mcap", "-o", "alone", cwd=tmp_path).returncode == 0
        versions = {(tmp_path / out / name / "results.json").read_bytes() for out in ("batch", "alone")}
        assert len(versions) == 1
        assert len(json.loads(versions.pop())["classification"]["views"]) == 2


def test_methods_settings_and_the_thesis_preset(done, tmp_path):
    folder, _ = done
    options = ("-o", tmp_path, "--views", "2", "--model", "none")
    finished = run("process", "blob.mcap", *options, "--settings", "thesis", cwd=folder)
    assert finished.returncode == 0, finished.stderr
    assert list(results(tmp_path / "blob")["reconstruction"]) == ["icp", "ransac_icp"]
    toml = tmp_path / "s.toml"
    toml.write_text("[ransac]\ntolerance = 3.0\n")
    run("process", "blob.mcap", *options, "--settings", toml, "--methods", "ransac-icp", cwd=folder)
    assert list(results(tmp_path / "blob")["reconstruction"]) == ["ransac_icp"]
    assert results(tmp_path / "blob")["settings"]["ransac"]["tolerance"] == 3.0


@pytest.mark.usefixtures("open3d")
def test_a_known_step_closes_a_bottle_and_a_mesh_is_written_where_asked_for(tmp_path):
    mcap_file.write(scan(n_views=3, points=8000, surface=bottle), tmp_path / "bottle.mcap")
    options = ("--methods", "refined", "--model", "none")
    finished = run("process", "bottle.mcap", "-o", "told", *options, "--step-deg", "20", "--mesh", cwd=tmp_path)
    assert finished.returncode == 0, finished.stderr
    told = results(tmp_path / "told" / "bottle")
    refined = told["reconstruction"]["refined"]
    assert [view["status"] for view in refined["views"]] == ["ok"] * 3
    assert refined["summary"]["max_rotation_error_deg"] < 1
    assert told["settings"]["pair"]["step_deg"] == 20
    vertices, _ = ply.read(tmp_path / "told" / "bottle" / "model_mesh.ply")
    assert len(vertices) > 1000
    assert told["model"]["mesh_triangles"] > 1000
    run("process", "bottle.mcap", "-o", "untold", *options, cwd=tmp_path)
    untold = results(tmp_path / "untold" / "bottle")
    refined = untold["reconstruction"]["refined"]
    assert [view["status"] for view in refined["views"]] == ["ok", "ambiguous", "ambiguous"]
    (freedom,) = refined["unobservable"]
    assert freedom["kind"] == "turn"
    assert untold["model"]["mesh_triangles"] is None
    assert not (tmp_path / "untold" / "bottle" / "model_mesh.ply").exists()


def test_without_truth_errors_are_null_and_all_else_works(tmp_path):
    session = scan(n_views=3, points=POINTS)
    mcap_file.write(in_memory(session.info, list(session.views())), tmp_path / "blob.mcap")
    assert run("process", "blob.mcap", "-o", "out", *QUICK, cwd=tmp_path).returncode == 0
    out = tmp_path / "out" / "blob"
    found = results(out)["reconstruction"]["pairwise"]
    assert {view["translation_error_m"] for view in found["views"]} == {None}
    assert [view["status"] for view in found["views"]] == ["ok"] * 3
    assert not (out / "poses_truth.tum").exists()
    assert (out / "model.ply").exists()


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("none.mcap", None, "no such file"),
        ("empty.mcap", b"", "the file is empty"),
        ("text.mcap", b"not a recording at all", "not an MCAP file"),
    ],
)
def test_what_is_no_recording_gets_one_sentence_and_status_2(tmp_path, name, content, says):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    finished = run("process", name, "-o", "out", cwd=tmp_path)
    assert finished.returncode == 2
    assert says in finished.stderr
    assert len(finished.stderr.strip().splitlines()) == 1
    assert not (tmp_path / "out" / name.removesuffix(".mcap")).exists()
    assert not list(tmp_path.glob("out/*.part"))


def test_a_process_of_its_own_ends_with_status_2_and_one_line_too(tmp_path):
    finished = start("process", "none.mcap", "-o", "out", cwd=tmp_path)
    assert (finished.returncode, finished.stdout) == (2, "")
    assert finished.stderr == "orbitscan: error: none.mcap: no such file; name a recording (.mcap)\n"


def test_recordings_of_other_topics_are_named_as_such(data, tmp_path):
    for path in sorted((data / "mcap_ros2_rosbag2").glob("*.mcap")):
        outcome = process_recording(path, Job(tmp_path))
        assert isinstance(outcome.error, UnreadableRecording), path.name
        assert "/camera/points" in outcome.message
    assert not list(tmp_path.iterdir())


def test_a_cut_recording_is_processed_as_far_as_it_goes_and_says_so(done, tmp_path):
    folder, _ = done
    whole = (folder / "blob.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    finished = run("process", "cut.mcap", "-o", "out", *QUICK, cwd=tmp_path)
    assert finished.returncode == 1
    assert "cut" in finished.stderr
    found = results(tmp_path / "out" / "cut")
    assert "unreadable" in found["input"]["damage"]
    statuses = [view["status"] for view in found["reconstruction"]["pairwise"]["views"]]
    assert statuses[:2] == ["ok", "ok"]
    assert statuses[-1] == "unreadable"


def test_one_flipped_bit_costs_one_view(done, tmp_path):
    folder, _ = done
    damaged = bytearray((folder / "blob.mcap").read_bytes())
    damaged[len(damaged) // 2] ^= 4
    (tmp_path / "flip.mcap").write_bytes(damaged)
    finished = run("process", "flip.mcap", "-o", "out", *QUICK, cwd=tmp_path)
    assert finished.returncode == 1
    statuses = [v["status"] for v in results(tmp_path / "out" / "flip")["reconstruction"]["pairwise"]["views"]]
    assert statuses.count("unreadable") == 1


def odd_views():
    """Name -> a view with something wrong, and the statuses that would be honest."""
    rng = np.random.default_rng(0)
    first, second, _ = scan(n_views=3, points=POINTS).views()
    plane = np.column_stack([rng.random((9000, 2)) * 0.2, np.ones(9000)])
    return {
        "no_points": (second.points[:0], {"too_few_points"}),
        "all_nan": (np.full_like(second.points, np.nan), {"too_few_points"}),
        "three_points": (second.points[:3], {"too_few_points"}),
        "plane": (plane, {"low_overlap", "diverged"}),
        "line": (np.outer(np.linspace(1, 1.2, 500), [0, 0, 1]), {"low_overlap", "diverged"}),
        "one_place": (np.tile(second.points[:1], (500, 1)), {"too_few_points"}),
        "twice": (first.points, {"ok"}),
        "some_nan": (np.vstack([second.points, np.full((99, 3), np.nan)]), {"ok"}),
    }


ODD = odd_views()


@pytest.mark.parametrize("name", ODD)
def test_an_odd_view_is_a_status_and_the_session_goes_on(tmp_path, name):
    points, honest = ODD[name]
    session = scan(n_views=3, points=POINTS)
    views = list(session.views())
    views[1] = replace(views[1], points=points.astype(np.float32))
    mcap_file.write(in_memory(session.info, views, session.truth()), tmp_path / "odd.mcap")
    finished = run("process", "odd.mcap", "-o", "out", *QUICK, cwd=tmp_path)
    assert finished.returncode == 0, finished.stderr
    views = results(tmp_path / "out" / "odd")["reconstruction"]["pairwise"]["views"]
    assert views[1]["status"] in honest
    assert [views[0]["status"], views[2]["status"]] == ["ok", "ok"]
    strict = run("process", "odd.mcap", "-o", "out", *QUICK, "--strict", cwd=tmp_path)
    assert "already done" in strict.stdout
    assert strict.returncode == (views[1]["status"] != "ok")


def test_one_view_only(tmp_path):
    mcap_file.write(scan(n_views=1, points=POINTS), tmp_path / "one.mcap")
    assert run("process", "one.mcap", "-o", "out", *QUICK, cwd=tmp_path).returncode == 0
    found = results(tmp_path / "out" / "one")
    assert found["reconstruction"]["pairwise"]["pairs"] == []
    assert found["model"]["method"] == "pairwise"


def test_an_output_that_cannot_be_written(done, tmp_path):
    folder, _ = done
    (tmp_path / "file").write_text("in the way")
    finished = run("process", folder / "blob.mcap", "-o", tmp_path / "file", cwd=tmp_path)
    assert finished.returncode == 2
    assert "cannot be written" in finished.stderr
    assert (tmp_path / "file").read_text() == "in the way"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--methods", "magic"], "no such method"),
        (["--views", "99:"], "selects no view"),
        (["--views", "7,8"], "there is no view 7"),
        (["--settings", "missing.toml"], "cannot be read"),
        (["--step-deg", "0"], "not a turntable's step"),
        (["--step-deg", "180"], "not a turntable's step"),
    ],
)
def test_wrong_options_are_status_2(done, options, says):
    folder, _ = done
    finished = run("process", "blob.mcap", "-o", "wrong", *options, cwd=folder)
    assert finished.returncode == 2
    assert says in finished.stderr
    assert not (folder / "wrong" / "blob").exists()


def test_two_inputs_of_one_name_are_refused_before_anything_runs(done, tmp_path):
    folder, _ = done
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "blob.mcap").write_bytes((folder / "blob.mcap").read_bytes())
    finished = run("process", folder / "blob.mcap", "a/blob.mcap", "-o", "out", cwd=tmp_path)
    assert finished.returncode == 2
    assert "same name" in finished.stderr
    assert not (tmp_path / "out").exists()


def test_in_a_batch_one_broken_recording_does_not_stop_the_others(done, tmp_path):
    folder, _ = done
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "good.mcap").write_bytes((folder / "blob.mcap").read_bytes())
    (tmp_path / "in" / "bad.mcap").write_bytes(b"rubbish")
    finished = run("process", "in", "-o", "out", "--views", "2", *QUICK, cwd=tmp_path)
    assert finished.returncode == 1
    assert "bad.mcap: not an MCAP file" in finished.stderr
    assert (tmp_path / "out" / "good" / "results.json").exists()
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"good", "summary.csv", "summary.parquet", "summary.rrd"}
    assert "1 of 2 recordings have results; 2 of their 2 views are placed with confidence; 1 failed." in finished.stdout


def test_help_imports_nothing_heavy():
    code = "import sys, orbitscan.processing.cli; print(*sys.modules)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "scipy", "open3d", "numba", "rerun", "pydantic"} & set(found.stdout.split())
