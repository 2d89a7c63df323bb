"""Points and poses come into the view's frame together, and the flags say how."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.recorder import poses
from orbitscan.recorder.alignment import right_handed_axes
from orbitscan.recorder.conversion import DIRECTIONS, METRES, CaptureOptions, Conversion, recorded
from orbitscan.recorder.exceptions import InvalidOption
from orbitscan.recorder.session import SessionInfo
from tests.geometry import random_pose

conversions = st.builds(
    Conversion,
    units=st.sampled_from(sorted(METRES)),
    scale=st.sampled_from([1.0, 0.2]),
    axes=st.sampled_from(right_handed_axes()),
    poses_are=st.sampled_from(DIRECTIONS),
    pose_axes=st.sampled_from(right_handed_axes()),
    pose_units=st.sampled_from(sorted(METRES)),
)


@given(conversions, st.integers(0, 2**32 - 1))
def test_a_pose_there_and_back(conversion, seed):
    T = random_pose(np.random.default_rng(seed))
    np.testing.assert_allclose(conversion.pose(conversion.source_pose(T)), T, atol=1e-12)
    np.testing.assert_allclose(conversion.source_pose(conversion.pose(T)), T, atol=1e-9)


@given(conversions, st.integers(0, 2**32 - 1))
def test_a_point_of_the_object_stays_where_it_is(conversion, seed):
    """A source in any convention tells of the same object, up to its scale."""
    rng = np.random.default_rng(seed)
    conversion = replace(conversion, pose_axes=conversion.axes, pose_units=conversion.units)
    T_file, in_source = random_pose(rng), rng.normal(size=(4, 3)) + 5
    T_object_source = poses.invert(T_file) if conversion.poses_are == "object-to-camera" else T_file
    metres = METRES[conversion.units] * conversion.scale
    in_object = poses.transform(T_object_source, in_source) * metres
    found = poses.transform(conversion.pose(T_file), conversion.points(in_source))
    np.testing.assert_allclose(found, in_object, atol=1e-6)


def test_points_and_origin_in_numbers():
    conversion = Conversion(units="mm", scale=2.0, axes="RUB")
    np.testing.assert_allclose(conversion.points(np.array([[1000.0, 2000, 3000]])), [[2, -4, -6]])
    assert conversion.points(np.array([[np.nan, 0, 0]])).dtype == np.float32
    assert conversion.origin((0, 0, 500)) == (0.0, 0.0, -1.0)
    assert "-" not in str(conversion.origin((0, 0, 0)))


@pytest.mark.parametrize(
    ("wrong", "what"),
    [
        ({"units": "inch"}, "units='inch'"),
        ({"pose_units": "km"}, "pose_units='km'"),
        ({"poses_are": "world"}, "poses_are='world'"),
        ({"axes": "RUF"}, "left-handed"),
        ({"pose_axes": "up"}, "not three of"),
        ({"scale": 0.0}, "scale=0"),
        ({"scale": -1.0}, "scale=-1"),
        ({"scale": float("nan")}, "scale=nan"),
    ],
)
def test_words_that_mean_nothing_are_refused(wrong, what):
    with pytest.raises(InvalidOption, match=what):
        Conversion(**wrong)


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({}, {}),
        ({"poses_are": "object-to-camera"}, None),
        ({"pose_axes": "RUB"}, None),
        ({"pose_units": "mm"}, None),
        ({"axes": "RFU", "pose_axes": "RFU"}, {"axes": "RFU"}),
        ({"axes": "RFU"}, {"axes": "RFU", "pose_axes": "RDF"}),
        ({"units": "mm"}, {"units": "mm", "pose_units": "m"}),
        ({"poses_are": "object-to-camera", "pose_axes": "RUB"}, None),
    ],
)
def test_what_is_said_to_lead_from_one_conversion_to_another(changed, said):
    changes = replace(Conversion(), **changed).changes(Conversion())
    assert changes == (changed if said is None else said)
    assert CaptureOptions(**changes).conversion() == replace(Conversion(), **changed)


@given(conversions)
def test_a_session_tells_how_it_was_converted(conversion):
    info = SessionInfo(
        "s", source_axes=conversion.axes, source_units=conversion.units, source_poses=conversion.pose_words
    )
    assert recorded(info) == replace(conversion, scale=1.0)


@pytest.mark.parametrize("words", ["", "somehow", "camera-to-object XYZ m", "a b c d e"])
def test_a_session_that_does_not_tell_was_converted_by_default(words):
    assert recorded(SessionInfo("s", source_poses=words)) == Conversion()
