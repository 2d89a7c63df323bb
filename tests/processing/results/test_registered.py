"""registered.mcap: estimated poses that a stranger's reader places the clouds by, and nobody takes for the truth."""

import weakref
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from orbitscan.processing.results.estimates import MethodResult, ViewEstimate
from orbitscan.processing.results.records import Model, SessionResult, Turntable
from orbitscan.processing.results.registered import place, registered, stand_upright
from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.session import SessionInfo
from tests import viewer
from tests.geometry import scan

ELEVATION = np.degrees(np.arctan2(0.4, 0.9))  # of `scan`'s camera


@pytest.fixture(scope="module")
def session():
    return scan(n_views=5, points=4000)


def estimated(session, statuses=None, stamps_ns=None):
    """The result of a session whose views are placed rightly, with the statuses of some."""
    truth, statuses = session.truth(), statuses or {}
    T_0_object = poses.invert(truth[0])
    views = tuple(ViewEstimate(i, statuses.get(i, "ok"), T_0_object @ T) for i, T in truth.items())
    merged = np.concatenate([poses.transform(T_0_object @ truth[v.index], v.points) for v in session.views()])
    return SessionResult(
        info=replace(session.info, elevation_deg=ELEVATION),
        views_used=tuple(truth),
        view_names=session.names,
        stamps_ns=stamps_ns or tuple(v.stamp_ns for v in session.views()),
        origin=0,
        reconstruction={"icp": MethodResult((), ()), "refined": MethodResult(views, ())},
        model=Model("refined", merged.astype(np.float32), None, np.empty((0, 3), np.float32)),
        turntable=None,
        seconds={},
        settings={},
        seed=0,
        centroids={},
    )


def read_as_a_stranger(path):
    """(time, sequence, T_object_camera, cloud (N, 3)) of each cloud, by the transform of its own time before it."""
    found, T = [], {}
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            if channel.topic == "/tf":
                t, q = decoded.translation, decoded.rotation
                assert (decoded.parent_frame_id, decoded.child_frame_id) == ("object", "camera")
                turn = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
                T[decoded.timestamp.ToNanoseconds()] = poses.make(turn, [t.x, t.y, t.z])
            else:
                time = decoded.timestamp.ToNanoseconds()
                points = np.frombuffer(decoded.data, np.float32).reshape(-1, decoded.point_stride // 4)[:, :3]
                found.append((time, message.sequence, T[time], points))
    return found


def write(path, session, **options):
    placement = place(estimated(session, **options))
    mcap_file.write(registered(session, placement), path)
    return placement


def test_a_stranger_finds_the_object_whole(session, tmp_path):
    write(tmp_path / "registered.mcap", session)
    found = read_as_a_stranger(tmp_path / "registered.mcap")
    assert [sequence for _, sequence, _, _ in found] == [0, 1, 2, 3, 4]
    placed = [poses.transform(T, points) for _, _, T, points in found]
    for before, after in pairwise(placed):  # 20 degrees apart
        distances, _ = cKDTree(before).query(after)
        assert np.percentile(distances, 75) < 0.006  # as far apart as a cloud's points are
    T_0 = {v.view: v.T_0_i for v in estimated(session).reconstruction["refined"].views}
    for i, (_, _, T, points) in enumerate(found):
        np.testing.assert_allclose(poses.invert(found[0][2]) @ T, T_0[i], atol=1e-9)
        np.testing.assert_array_equal(points, session.load(i).points)


def test_only_ok_views_are_in_it_and_each_is_known_by_name_and_recorded_index(session, tmp_path):
    placement = write(tmp_path / "registered.mcap", session, statuses={1: "low_overlap", 3: "ambiguous"})
    back = mcap_file.read(tmp_path / "registered.mcap")
    assert back.names == ("view_000", "view_002", "view_004")
    assert [v.stamp_ns for v in back.views()] == [1 * 10**9, 3 * 10**9, 5 * 10**9]
    assert [v.index for v in back.views()] == [0, 1, 2]
    assert back.info.views == 3
    assert placement.left_out == 2
    assert back.info.source_poses == "estimated by refined, recorded views 0,2,4"


def test_its_poses_are_called_estimates_and_the_truth_is_never_asked_for(session, tmp_path):
    def refuse():
        raise AssertionError("the truth was asked for")

    placement = place(estimated(session))
    mcap_file.write(registered(replace(session, load_truth=refuse), placement), tmp_path / "registered.mcap")
    back = mcap_file.read(tmp_path / "registered.mcap")
    info = back.info
    assert info.source_poses == "estimated by refined, recorded views 0:5"
    assert back.truth() == {}  # nothing is measured against them
    assert (info.name, info.capture) == (session.info.name, session.info.capture)


@pytest.mark.parametrize("stamps_ns", [(7,) * 5, (1, 2, 3, 2, 5)])
def test_views_of_equal_stamps_get_their_own(session, tmp_path, stamps_ns):
    write(tmp_path / "registered.mcap", session, stamps_ns=stamps_ns)
    found = read_as_a_stranger(tmp_path / "registered.mcap")
    assert [time for time, *_ in found] == [i * 10**9 for i in range(1, 6)]
    assert len({tuple(T[:3, 3]) for _, _, T, _ in found}) == 5
    assert "stamps made up" in mcap_file.read(tmp_path / "registered.mcap").info.source_poses


def test_stamps_that_fall_are_kept(session, tmp_path):
    stamps_ns = (50, 40, 30, 20, 10)
    write(tmp_path / "registered.mcap", session, stamps_ns=stamps_ns)
    assert tuple(time for time, *_ in read_as_a_stranger(tmp_path / "registered.mcap")) == stamps_ns


def test_the_same_results_give_the_same_bytes(session, tmp_path):
    for name in ("a", "b"):
        write(tmp_path / name, session)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_one_cloud_is_in_memory_at_a_time(session, tmp_path):
    clouds = []

    def load(index):
        assert sum(cloud() is not None for cloud in clouds) <= 1  # the one that was written last
        view = session.load(index)
        view = replace(view, points=view.points.copy())
        clouds.append(weakref.ref(view.points))
        return view

    mcap_file.write(registered(replace(session, load=load), place(estimated(session))), tmp_path / "registered.mcap")
    assert len(clouds) == 5


def test_a_failure_leaves_no_file(session, tmp_path):
    def load(index):
        if index == 3:
            raise OSError(5, "Input/output error")
        return session.load(index)

    failing = registered(replace(session, load=load), place(estimated(session)))
    with pytest.raises(Exception, match="Input/output error"):
        mcap_file.write(failing, tmp_path / "registered.mcap")
    assert not list(tmp_path.iterdir())


def test_without_a_model_nothing_is_placed(session):
    assert place(replace(estimated(session), model=None)) is None


@pytest.mark.parametrize(
    ("statuses", "expected"), [({}, 18.0), ({1: "diverged", 3: "diverged"}, 9.0), ({1: "x"}, None)]
)
def test_views_a_turn_are_those_of_the_views_in_it(session, statuses, expected):
    turning = replace(session, info=replace(session.info, views_per_turn=18.0))
    assert registered(turning, place(estimated(turning, statuses))).info.views_per_turn == expected


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("elevation_deg", [None, 0.0, 30.0, 89.9])
def test_the_frame_stands_upright_before_the_sensor(rng, sign, elevation_deg):
    points = rng.normal(size=(500, 3)) * 0.05 + [0.01, 0.02, 1.0]
    tilt = np.radians(40.0)
    axis = sign * np.array([0.0, -np.cos(tilt), -np.sin(tilt)])
    turntable = Turntable(axis, np.zeros(3), 20.0, ())
    for known, up in ((turntable, sign * axis), (None, None)):
        T = poses.check(stand_upright(points, known, elevation_deg), "T_object_0")
        if up is None:
            angle = np.radians(elevation_deg or 0.0)
            up = np.array([0.0, -np.cos(angle), -np.sin(angle)])
        np.testing.assert_allclose(T[:3, :3] @ up, [0, 0, 1], atol=1e-12)
        low, high = np.percentile(poses.transform(T, points), [1, 99], axis=0)
        np.testing.assert_allclose((low + high) / 2, 0, atol=1e-9)
        forward = T[:3, 2]  # of the sensor, in the frame
        assert forward[1] > 0 or abs(forward[1]) < 0.01
        assert abs(forward[0]) < 1e-9


def test_its_transforms_are_foxgloves_own(session, tmp_path):
    write(tmp_path / "registered.mcap", session)
    with (tmp_path / "registered.mcap").open("rb") as stream:
        schemas = {s.name for s in make_reader(stream).get_summary().schemas.values()}
    assert schemas == {FrameTransform.DESCRIPTOR.full_name, "foxglove.PointCloud"}


@pytest.fixture
def rng():
    return np.random.default_rng(3)


def test_facts_of_the_session_stay(session):
    info = SessionInfo("cup", 5, category="coffee_mug", sensor="kinect", sensor_origin=None, source_axes="RUB")
    told = registered(replace(session, info=info), place(estimated(session))).info
    assert replace(told, source_poses="") == info


@pytest.mark.usefixtures("renderer")
def test_the_viewer_draws_it_without_a_complaint(session, tmp_path):
    path = tmp_path / "registered.mcap"
    write(path, session, statuses={2: "diverged"})
    with viewer.open_viewer(path) as client:
        assert client.get_state().views
        assert viewer.find_reports(client) == []
