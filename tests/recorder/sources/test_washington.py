"""A tree of the Washington data set becomes a session per circle."""

import numpy as np
import pytest

from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import InvalidOption, UnknownFormat
from orbitscan.recorder.sources import open_capture

PCD = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n{} 700 30\n"


def write_frames(folder, *names):
    for i, name in enumerate(names):
        path = folder / f"{name}.pcd"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(PCD.format(i))
    return folder


def test_a_session_per_circle_frames_in_natural_order(tmp_path):
    write_frames(
        tmp_path,
        *(f"coffee_mug/coffee_mug_2/coffee_mug_2_1_{k}" for k in (11, 1, 101, 6)),
        *(f"coffee_mug/coffee_mug_2/coffee_mug_2_4_{k}" for k in (5, 10)),
        "coffee_mug/coffee_mug_10/coffee_mug_10_2_1",
        "cap/cap_1/cap_1_3_7",
    )
    (tmp_path / "cap" / "cap_1" / "cap_1_3_7_mask.png").touch()
    sessions = open_capture(tmp_path)
    assert [session.info.name for session in sessions] == [
        "cap_1_3",
        "coffee_mug_2_1",
        "coffee_mug_2_4",
        "coffee_mug_10_2",
    ]
    circle = sessions[1]
    assert circle.names == tuple(f"coffee_mug_2_1_{k}" for k in (1, 6, 11, 101))
    assert [view.points[0, 0] for view in circle.views()] == [1, 3, 0, 2]
    assert (circle.info.category, circle.info.instance) == ("coffee_mug", "2")
    assert [s.info.elevation_deg for s in sessions] == [None, 30, 60, 45]
    assert [s.info.capture for s in sessions] == ["unknown", "circle", "unknown", "unknown"]
    assert {s.info.views_per_turn for s in sessions} == {None}


def test_depth_is_y_and_up_is_z(tmp_path):
    (session,) = open_capture(write_frames(tmp_path, "cap_1_1_1") / "cap_1_1_1.pcd")
    np.testing.assert_array_equal(session.load(0).points, [[0, -30, 700]])
    assert session.info.source_axes == "RFU"


def test_a_frame_that_is_there_twice_is_refused(tmp_path):
    with pytest.raises(UnknownFormat, match=r"cap_1_1_1\.pcd and .*cap_1_1_1\.pcd; keep one"):
        open_capture(write_frames(tmp_path, "a/cap_1_1_1", "b/cap_1_1_1"))


def test_other_clouds_in_the_tree_are_left_out_only_where_the_format_is_named(tmp_path):
    write_frames(tmp_path, "cap/cap_1_1_1", "cap/cap_1_1_2", "cap/merged")
    with pytest.raises(UnknownFormat):
        open_capture(tmp_path)
    (session,) = open_capture(tmp_path, CaptureOptions(format="washington"))
    assert session.names == ("cap_1_1_1", "cap_1_1_2")


def test_what_the_format_settles_is_not_up_to_the_user(tmp_path):
    with pytest.raises(InvalidOption, match="category: the washington format settles it"):
        open_capture(write_frames(tmp_path, "cap_1_1_1"), CaptureOptions(category="mug"))


def test_the_real_tree(data):
    sessions = {session.info.name: session for session in open_capture(data / "washington" / "rgbd-dataset")}
    assert sorted(sessions) == [
        "bell_pepper_1_1", "bowl_2_1", "cap_1_1", "coffee_mug_2_1", "keyboard_1_1", "soda_can_2_1",
    ]  # fmt: skip
    cap = sessions["cap_1_1"]
    assert cap.names == tuple(f"cap_1_1_{k}" for k in range(1, 187, 5))
    assert (cap.info.capture, cap.info.views, cap.info.elevation_deg) == ("circle", 38, 30)
    view = cap.load(20)
    assert view.colors.shape == view.points.shape
    assert 0.5 < np.nanmedian(view.points[:, 2]) < 0.9  # in front of the camera
    assert sessions["bowl_2_1"].info.capture == "unknown"
    assert sessions["coffee_mug_2_1"].info.category == "coffee_mug"
