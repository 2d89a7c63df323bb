"""Real scans, end to end; skipped with a reason where they are absent."""

import numpy as np
import pytest

from orbitscan.processing.batch.recording import Job, process_recording
from orbitscan.processing.classification.classifier import Classifier
from orbitscan.processing.results.folder import read_results
from orbitscan.recorder import mcap_file
from orbitscan.recorder.simulation.camera import simulate
from orbitscan.recorder.sources import open_capture


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
    found = read_results(outcome.folder).results.reconstruction
    ours = found["pairwise"].pairs
    assert [(pair.source, pair.target) for pair in ours] == [(1, 0), (2, 1)]
    for pair in ours:
        assert pair.status == "ok"
        assert pair.errors.rotation_error_deg < 1.5
        assert pair.errors.center_error_m < 0.002
    for error in ("rotation_error_deg", "center_error_m"):
        median = {method: np.median([getattr(pair.errors, error) for pair in found[method].pairs]) for method in found}
        assert median["icp"] > 5 * median["pairwise"]


@pytest.fixture(scope="module")
def whole_bunny(bunny, tmp_path_factory):
    """The ten scans, of which only those of the ring are in a useful order."""
    folder = tmp_path_factory.mktemp("whole_bunny")
    return read_results(
        process_recording(bunny, Job(folder, views="all", methods=("pairwise", "refined"))).folder
    ).results


def test_no_pair_of_the_bunny_that_is_called_ok_is_wrong(whole_bunny):
    for found in whole_bunny.reconstruction.values():
        called_ok = [pair for pair in found.pairs if pair.status == "ok"]
        assert len(called_ok) >= 4
        for pair in called_ok:
            assert pair.errors.rotation_error_deg < 5
            assert pair.errors.center_error_m < 0.01


def test_the_bunnys_ring_is_right_where_it_is_called_ok(whole_bunny):
    names = whole_bunny.session.view_names
    ring = [names.index(f"bun{angle:03d}") for angle in (0, 45, 90, 180, 270, 315)]
    ring = {frozenset(pair) for pair in zip(ring, ring[1:] + ring[:1], strict=True)}
    for method, least in (("pairwise", 2), ("refined", 3)):
        pairs = whole_bunny.reconstruction[method].pairs
        called_ok = [p for p in pairs if p.status == "ok" and frozenset((p.source, p.target)) in ring]
        assert len(called_ok) >= least
        for pair in called_ok:
            assert pair.errors.rotation_error_deg < 1.5, method
            assert pair.errors.center_error_m < 0.002, method


def test_all_ten_scans_of_the_bunny_are_placed(whole_bunny):
    views = whole_bunny.reconstruction["refined"].views
    assert len(views) == 10
    for view in views:
        assert view.T_0_i is not None, view
        assert view.status == "ok", view
        assert view.errors.rotation_error_deg < 1, view


@pytest.fixture(scope="module")
def kinect(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("kinect")
    return folder, convert(data / "washington" / "rgbd-dataset", folder)


def test_a_kinect_circle_without_truth(kinect):
    folder, recordings = kinect
    assert set(recordings) >= {"cap_1_1", "bell_pepper_1_1", "coffee_mug_2_1", "soda_can_2_1"}
    outcome = process_recording(recordings["cap_1_1"], Job(folder / "out", views="18", methods=("pairwise", "refined")))
    found = read_results(outcome.folder).results
    views = found.reconstruction["pairwise"].views
    assert len(views) == 18
    assert {view.errors.translation_error_m for view in views} == {None}
    assert sum(view.status == "ok" for view in views) >= 17
    refined = found.reconstruction["refined"]
    assert [view.status for view in refined.views] == ["ok"] * 18
    assert refined.loop_closed
    deviations = found.turntable.deviations
    assert len(deviations) == 18
    assert max(deviation.wobble_deg for deviation in deviations) < 2
    assert found.model.method == "refined"
    assert found.model.points > 10_000


def test_the_packaged_model_knows_real_views_of_its_categories(data):
    classifier = Classifier()
    answers = {}
    for session in open_capture(data / "washington" / "rgbd-dataset"):
        views = list(session.views())
        answers[session.info] = classifier.classify_views([v.index for v in views], [v.points for v in views])
    assert len(answers) >= 6
    for info, found in answers.items():
        if info.category in classifier.categories:
            assert np.mean([answer.likeliest == info.category for answer in found]) >= 0.9
            assert classifier.fuse(found).category == info.category


def test_the_packaged_model_knows_meshes_of_others(data):
    classifier = Classifier()
    for name, category in (("meshes_contactdb/mug.stl", "coffee_mug"), ("meshes_ycb_hoi4d/ycb_024_bowl.obj", "bowl")):
        views = list(simulate(str(data / name), views=6, elevation_deg=45, sensor="kinect").views())
        found = classifier.classify_views([v.index for v in views], [v.points for v in views])
        assert [answer.likeliest for answer in found] == [category] * 6
