"""Each finding is found where it is due, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.recorder import poses
from orbitscan.recorder.check import check
from orbitscan.recorder.conversion import Conversion
from orbitscan.recorder.exceptions import InvalidPose
from orbitscan.recorder.session import Session, SessionInfo, View, in_memory
from orbitscan.recorder.sources import open_capture
from tests.geometry import scan
from tests.recorder.test_alignment import BLOB, INVERTED, misread

GOOD = scan(n_views=4, step_deg=30, points=6000)
RNG = np.random.default_rng(0)


def change(session=GOOD, points=None, truth=None, keep=None, **info):
    """The session with other points (view -> points), poses or facts."""
    views = [replace(view, points=(points or {}).get(view.index, view.points)) for view in session.views()][:keep]
    known = session.truth() if truth is None else truth
    return in_memory(replace(session.info, views=len(views), **info), views, known)


def all_points(change_points, session=GOOD):
    return {view.index: change_points(view.points).astype(np.float32) for view in session.views()}


def findings(session, severity=None):
    return [str(finding) for finding in check(session) if severity in (None, finding.severity)]


def test_a_good_session_is_good():
    assert [finding.severity for finding in check(GOOD)] == ["info"]
    assert findings(GOOD)[0].startswith("info: poses align the views to ")


def test_a_session_without_poses_says_so():
    assert findings(change(truth={})) == [
        "info: no true poses, so no errors will be told; name their file with poses where they exist"
    ]


def test_a_session_with_some_poses_says_how_many():
    truth = {i: T for i, T in GOOD.truth().items() if i != 2}
    assert findings(change(truth=truth))[0] == "info: true poses of 3 of 4 views"


@pytest.mark.parametrize(
    ("points", "finding"),
    [
        (np.empty((0, 3)), "problem: view 1: no points; leave the view out"),
        (np.full((500, 3), np.nan), "problem: view 1: all points are NaN; leave the view out"),
        (GOOD.load(1).points[:3], "problem: view 1: fewer than 10 points; leave the view out"),
        (GOOD.load(0).points, "problem: views 0-1: identical clouds; keep one of them"),
        (np.linspace([0, 0, 1], [0.1, 0.2, 1.1], 500), "problem: view 1: the points lie on a line; leave the view out"),
        (
            np.pad(RNG.uniform(0, 0.3, (2000, 2)), ((0, 0), (0, 1)), constant_values=1),
            "problem: view 1: the points lie on a plane, along which no motion can be seen; "
            "scan the object from where it shows relief",
        ),
    ],
)
def test_views_that_cannot_be_registered(points, finding):
    session = change(points={1: np.asarray(points, np.float32)}, truth={})
    assert findings(session, "problem") == [finding]


def test_a_noisy_plane_is_a_plane_and_a_keyboard_is_none(data):
    plane = np.c_[RNG.uniform(-0.15, 0.15, (4000, 2)), 1 + RNG.normal(scale=0.003, size=4000)]
    assert "problem: view 2: the points lie on a plane" in findings(change(points={2: plane.astype(np.float32)}))[0]
    sessions = open_capture(data / "washington" / "rgbd-dataset" / "keyboard")
    assert not [finding for session in sessions for finding in findings(session, "problem")]


def test_some_nan_points_are_worth_a_word():
    points = GOOD.load(3).points.copy()
    points[::7] = np.nan
    assert findings(change(points={3: points}))[0] == "info: view 3: some points are NaN; they are left out"


def test_views_are_counted_in_runs():
    empty = {i: np.empty((0, 3), np.float32) for i in (0, 1, 2, 5, 7, 8)}
    assert findings(change(BLOB, points=empty), "problem")[0].startswith("problem: views 0-2, 5, 7-8: no points")


def test_one_view_only():
    assert "warning: one view only: there is nothing to register it with" in findings(change(keep=1, truth={}))


def test_a_session_without_any_points_ends_in_findings():
    nothing = all_points(lambda points: points[:0])
    assert findings(change(points=nothing), "problem") == ["problem: views 0-3: no points; leave the view out"]


def test_damage_is_a_problem():
    session = change()
    lost = View(2, "view_002", 1, np.empty((0, 3), np.float32), None, "damaged in the recording")
    damaged = Session(
        session.info,
        session.names,
        lambda i: lost if i == 2 else session.load(i),
        session.load_truth,
        "parts of the file are damaged",
    )
    assert findings(damaged, "problem") == [
        "problem: parts of the file are damaged; record the session again",
        "problem: view 2: unreadable; record the session again",
    ]


@pytest.mark.parametrize(
    ("factor", "units", "remedy"),
    [
        (1000, "m", "pass units='mm' if these are millimetres"),
        (1000, "mm", "check units and scale"),
        (0.001, "mm", "pass units='m' if these are metres"),
        (0.001, "m", "check units and scale"),
    ],
)
def test_lengths_that_cannot_be(factor, units, remedy):
    session = change(points=all_points(lambda points: points * factor), truth={}, source_units=units)
    (finding,) = findings(session, "problem")
    assert finding.startswith("problem: the object measures ")
    assert finding.endswith(f"; {remedy}")


def test_a_room_s_length_is_no_problem():
    assert not findings(change(points=all_points(lambda points: points * 20), truth={}), "problem")


def test_an_unknown_sensor_origin_is_worth_a_warning():
    (finding,) = findings(change(sensor_origin=None), "warning")
    assert "unknown sensor origin: free-space tests are off" in finding


def test_centered_clouds_have_no_sensor_in_their_midst():
    centered = all_points(lambda points: points - points.mean(axis=0))
    (finding,) = findings(change(points=centered, truth={}), "problem")
    assert finding == "problem: the sensor's origin lies within the object; pass sensor_origin='unknown'"
    assert not findings(change(points=centered, truth={}, sensor_origin=(0.0, 0.0, -10.0)), "problem")


@pytest.mark.parametrize("axes", ["RUB", "RFU", "FLU"])
@pytest.mark.parametrize("read", ["RDF", "DLF"])
def test_points_that_do_not_lie_in_front_of_the_camera(axes, read):
    A = poses.axes_to_rdf(axes).T  # from RDF to what the file holds
    wrong = Conversion(axes=read, pose_axes=read)
    session = change(points=all_points(lambda points: wrong.points(points @ A.T)))
    session = misread(session, Conversion(axes=axes, pose_axes=axes), wrong)
    assert findings(session, "problem") == [
        f"problem: the points do not lie in front of the camera; pass axes='{axes}'"
    ]
    assert any("poses align the views" in finding for finding in findings(session))


def test_wrong_axes_of_the_points_and_right_ones_of_the_poses():
    A = poses.axes_to_rdf("RFU").T
    session = change(BLOB, points=all_points(lambda points: points @ A.T, BLOB), source="clouds")
    found = findings(session, "problem")
    assert found[0].endswith("pass axes='RFU'")
    assert found[1].endswith("pass axes='RFU', pose_axes='RDF'")


def test_inverted_poses_name_the_setting_that_mends_them():
    session = misread(change(BLOB, source="clouds"), INVERTED)
    (finding,) = findings(session, "problem")
    assert finding.startswith("problem: poses: ")
    assert " as given, " in finding
    assert finding.endswith(" inverted; pass poses_are='object-to-camera'")


def test_no_setting_is_named_where_the_format_takes_none():
    (finding,) = findings(misread(change(BLOB, source="stanford"), INVERTED), "problem")
    assert finding.endswith(" inverted")


def test_poses_of_something_else():
    truth = {i: poses.make(T[:3, :3], T[:3, 3] + RNG.normal(size=3)) for i, T in BLOB.truth().items()}
    (finding,) = findings(change(BLOB, truth=truth), "problem")
    assert "no other reading of them does better; check that they belong to these clouds" in finding


def test_poses_with_errors_are_worth_a_warning():
    truth = {i: poses.make(np.eye(3), RNG.normal(size=3) * 0.006) @ T for i, T in BLOB.truth().items()}
    (finding,) = findings(change(BLOB, truth=truth), "warning")
    assert finding.startswith("warning: poses align the views only to ")


def test_a_pose_that_is_no_rotation():
    def broken():
        raise InvalidPose("s.mcap, pose of view 3", "a quaternion has the length 0, not 1", "give a unit quaternion")

    session = Session(SessionInfo("s", 4), GOOD.names, GOOD.load, broken)
    assert findings(session, "problem") == [
        "problem: s.mcap, pose of view 3: a quaternion has the length 0, not 1; give a unit quaternion"
    ]


def test_real_scans_as_they_are(data):
    assert findings(open_capture(data / "stanford_bunny")[0]) == ["info: poses align the views to 0.44 mm"]
    (mug_alone,) = open_capture(data / "washington" / "rgbd-dataset" / "coffee_mug")
    assert not findings(mug_alone, "problem")
    (mug,) = open_capture(data / "rug_restaurant20_gazebo" / "mug")
    assert findings(mug, "problem") == [
        "problem: the sensor's origin lies within the object; pass sensor_origin='unknown'"
    ]
