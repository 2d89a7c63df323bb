"""Folders of clouds become one session, its poses where they belong."""

import json
from dataclasses import replace

import numpy as np
import pytest

from orbitscan.recorder import poses
from orbitscan.recorder.conversion import METRES, CaptureOptions
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose, UnknownFormat, UnreadableCloud
from orbitscan.recorder.sources import clouds, open_capture
from tests.geometry import random_pose

STEMS = ["view_0", "view_1", "view_2", "view_10"]
MOTIONS = [random_pose(np.random.default_rng(seed)) for seed in range(4)]


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "mug"
    path.mkdir()
    for i, stem in enumerate(STEMS):
        np.save(path / f"{stem}.npy", np.full((i + 1, 3), [i, 10, 100], np.float32))
    return path


def write_json(path, content):
    path.write_text(json.dumps(content, default=lambda T: T.tolist()))
    return path


def test_views_come_in_natural_order_of_their_names(folder):
    (folder / "notes.txt").write_text("1 2 3")
    (session,) = open_capture(folder)
    assert session.names == tuple(STEMS)
    assert session.info.name == "mug"
    assert (session.info.views, session.info.source, session.info.source_poses) == (4, "clouds", "")
    assert [view.stamp_ns for view in session.views()] == [10**9, 2 * 10**9, 3 * 10**9, 4 * 10**9]
    assert [len(view.points) for view in session.views()] == [1, 2, 3, 4]
    assert session.truth() == {}


def test_views_are_read_when_they_are_loaded(folder):
    (session,) = open_capture(folder)
    (folder / "view_2.npy").unlink()
    assert len(session.load(3).points) == 4
    with pytest.raises(UnreadableCloud, match=r"view_2\.npy"):
        session.load(2)


def test_one_file_is_a_session_of_one_view(folder):
    (session,) = open_capture(folder / "view_10.npy")
    assert (session.names, session.info.name, len(session.load(0).points)) == (("view_10",), "view_10", 4)


def test_the_options_describe_the_session(folder):
    options = CaptureOptions(
        category="coffee_mug", instance="3", name="morning", sensor_origin="unknown", elevation=20.0
    )
    info = open_capture(folder, options)[0].info
    assert info.elevation_deg == 20.0
    assert (info.category, info.instance, info.name, info.sensor_origin) == ("coffee_mug", "3", "morning", None)


def test_named_poses_go_to_their_clouds(folder):
    named = {"view_10": MOTIONS[3], "view_1": MOTIONS[1], "view_0.npy": MOTIONS[0], "view_2": None}
    write_json(folder / "poses.json", named)
    (session,) = open_capture(folder)
    assert sorted(session.truth()) == [0, 1, 3]
    for i, T in session.truth().items():
        np.testing.assert_allclose(T, MOTIONS[i], atol=1e-12)
    assert session.info.source_poses == "camera-to-object RDF m"


def test_poses_without_names_go_by_order(folder):
    lines = [poses.to_tum_line(10**9 * (7 + i), T) for i, T in enumerate(MOTIONS)]
    (folder / "poses.tum").write_text("\n".join(lines))
    (session,) = open_capture(folder)
    assert [view.stamp_ns for view in session.views()] == [7 * 10**9, 8 * 10**9, 9 * 10**9, 10 * 10**9]
    for i, T in enumerate(MOTIONS):
        np.testing.assert_allclose(session.truth()[i], T, atol=1e-9)


def test_names_that_match_no_cloud_go_by_their_natural_order(folder, tmp_path):
    listed = write_json(tmp_path / "p.json", {"10": MOTIONS[3], "2": MOTIONS[2], "0": MOTIONS[0], "1": MOTIONS[1]})
    (session,) = open_capture(folder, CaptureOptions(poses=listed))
    for i, T in session.truth().items():
        np.testing.assert_allclose(T, MOTIONS[i], atol=1e-12)


def test_poses_that_do_not_fit_the_clouds_are_refused_with_both_counts(folder):
    write_json(folder / "poses.json", MOTIONS[:3])
    with pytest.raises(InvalidPose, match="holds 3 poses for 4 clouds"):
        open_capture(folder)


def test_a_pose_of_a_cloud_that_is_not_there_is_refused(folder):
    write_json(folder / "poses.json", {"view_0": MOTIONS[0], "view_7": MOTIONS[1]})
    with pytest.raises(InvalidPose, match="names 'view_7', which is no cloud"):
        open_capture(folder)


def test_a_cloud_with_two_poses_is_refused(folder):
    write_json(folder / "poses.json", {"view_0": MOTIONS[0], "view_0.npy": MOTIONS[1]})
    with pytest.raises(InvalidPose, match="names a cloud twice"):
        open_capture(folder)


def test_a_pose_that_is_no_rotation_is_refused_by_its_cloud(folder):
    write_json(folder / "poses.json", [*MOTIONS[:3], np.diag([2, 2, 2, 1])])
    with pytest.raises(InvalidPose, match=r"poses\.json, pose of view_10\.npy: a pose is not a rotation"):
        open_capture(folder)


def test_two_files_of_poses_are_refused_until_one_is_named(folder):
    (folder / "poses.txt").write_text("\n".join(["1 0 0 0 0 1 0 0 0 0 1 0"] * 4))
    write_json(folder / "truth.json", MOTIONS)
    with pytest.raises(InvalidPose, match=r"poses\.txt and truth\.json may both hold poses; name one with poses"):
        open_capture(folder)
    (session,) = open_capture(folder, CaptureOptions(poses=folder / "truth.json"))
    np.testing.assert_allclose(session.truth()[2], MOTIONS[2], atol=1e-12)


def test_a_pose_file_is_no_cloud(folder):
    (folder / "poses.csv").write_text("\n".join(["1 0 0 0 0 1 0 0 0 0 1 0"] * 4))
    (session,) = open_capture(folder)
    assert session.names == tuple(STEMS)
    assert len(session.truth()) == 4


def test_two_files_of_one_view_are_refused(folder):
    (folder / "view_1.xyz").write_text("0 0 0")
    with pytest.raises(UnknownFormat, match=r"view_1\.npy and view_1\.xyz"):
        open_capture(folder)


def test_units_scale_and_axes_hold_for_points_and_poses(folder, tmp_path):
    given = CaptureOptions(poses=write_json(tmp_path / "p.json", MOTIONS), units="mm", scale=3.0, axes="RFU")
    (plain,) = open_capture(folder, CaptureOptions(poses=given.poses))
    (session,) = open_capture(folder, given)
    assert (session.info.source_units, session.info.source_axes) == ("mm", "RFU")
    for i in range(4):
        seen = plain.load(i).points  # as they stand in the file
        x, y, z = 0.003 * seen[0]
        np.testing.assert_allclose(session.load(i).points[0], [x, -z, y], rtol=1e-6)
        there = poses.transform(plain.truth()[i], seen) * 0.003
        np.testing.assert_allclose(poses.transform(session.truth()[i], session.load(i).points), there, atol=1e-5)


def test_poses_may_have_their_own_direction_axes_and_units(folder, tmp_path):
    (plain,) = open_capture(folder, CaptureOptions(poses=write_json(tmp_path / "p.json", MOTIONS)))
    theirs = []
    for T in MOTIONS:  # as OpenGL would write world-to-camera, in cm
        T = poses.invert(T @ poses.make(poses.axes_to_rdf("RUB"), np.zeros(3)))
        theirs.append(poses.make(T[:3, :3], T[:3, 3] / METRES["cm"]))
    options = CaptureOptions(
        poses=write_json(tmp_path / "q.json", theirs), poses_are="object-to-camera", pose_axes="rub", pose_units="cm"
    )
    (session,) = open_capture(folder, options)
    assert session.info.source_poses == "object-to-camera RUB cm"
    for i in range(4):
        np.testing.assert_allclose(session.truth()[i], plain.truth()[i], atol=1e-9)
        np.testing.assert_array_equal(session.load(i).points, plain.load(i).points)


def test_the_sensor_s_origin_moves_with_the_points(folder):
    options = CaptureOptions(sensor_origin=(0, 0, 500), units="mm", axes="RUB")
    assert open_capture(folder, options)[0].info.sensor_origin == (0.0, 0.0, -0.5)
    assert open_capture(folder)[0].info.sensor_origin == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "wrong", [{"units": "inch"}, {"axes": "RUF"}, {"pose_axes": "Z"}, {"scale": 0.0}, {"poses_are": "x"}]
)
def test_options_that_mean_nothing_are_refused_before_a_file_is_read(folder, wrong):
    with pytest.raises(InvalidOption):
        open_capture(folder, replace(CaptureOptions(poses=folder / "none.json"), **wrong))


def test_columns_are_read_by_their_names(tmp_path):
    for i in range(2):
        (tmp_path / f"{i}.csv").write_text(f"ax,ay,az,bx,by,bz\n0,0,0,{i},2,3\n")
    (session,) = open_capture(tmp_path, CaptureOptions(columns=("bx", "by", "bz")))
    np.testing.assert_array_equal([view.points[0] for view in session.views()], [[0, 2, 3], [1, 2, 3]])


def test_a_folder_without_clouds_is_refused(tmp_path):
    with pytest.raises(UnknownFormat, match="holds no cloud file"):
        clouds.sessions(tmp_path, CaptureOptions())
