"""Poses are judged rightly: the right ones are never blamed, the wrong ones are named by what is wrong with them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.recorder import alignment, poses
from orbitscan.recorder.conversion import Conversion
from orbitscan.recorder.session import SessionInfo, View, in_memory
from orbitscan.recorder.sources import open_capture
from tests.geometry import scan


def box(rng, points):
    """A box without a lid of its own: 20 x 12 x 28 cm, and its normals."""
    surface = rng.uniform(-1, 1, (points, 3))
    side, sign = rng.integers(0, 3, points), rng.choice([-1.0, 1.0], points)
    normals = np.zeros((points, 3))
    surface[np.arange(points), side] = normals[np.arange(points), side] = sign
    return surface * [0.1, 0.06, 0.14], normals


def sphere(rng, points):
    normals = rng.normal(size=(points, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return 0.1 * normals, normals


def orbit(shape, views=9, noise=0.0005, centered=False):
    """A session of a shape, a view every 30 degrees; every view draws its own points, as a sensor does."""
    rng = np.random.default_rng(0)
    clouds, truth = [], {}
    for i in range(views):
        surface, normals = shape(rng, 8_000)
        eye = Rotation.from_euler("z", 30 * i, degrees=True).apply([0.9, 0.0, 0.45])
        forward = -eye / np.linalg.norm(eye)
        right = np.cross(forward, [0, 0, 1])
        right /= np.linalg.norm(right)
        T = poses.make(np.column_stack([right, np.cross(forward, right), forward]), eye)
        seen = surface[np.einsum("ni,ni->n", normals, eye - surface) > 0.2]
        points = poses.transform(poses.invert(T), seen) + rng.normal(scale=noise, size=seen.shape)
        center = points.mean(axis=0) if centered else np.zeros(3)
        clouds.append(View(i, f"view_{i}", (i + 1) * 10**9, (points - center).astype(np.float32)))
        truth[i] = T @ poses.make(np.eye(3), center)
    return in_memory(SessionInfo("s", views, source="clouds"), clouds, truth)


def misread(session, right: Conversion, read: Conversion = Conversion()):  # noqa: B008
    """The session as it comes out where a file that means `right` is read by `read`."""
    truth = {i: read.pose(right.source_pose(T)) for i, T in session.truth().items()}
    info = replace(session.info, source_units=read.units, source_axes=read.axes, source_poses=read.pose_words)
    return in_memory(info, list(session.views()), truth)


BLOB = scan(n_views=9, step_deg=30, points=8_000)
BOX = orbit(box)
CENTERED = orbit(box, centered=True)


@pytest.mark.parametrize("session", [BLOB, BOX, CENTERED, orbit(sphere)], ids=["blob", "box", "centered", "sphere"])
def test_right_poses_are_not_blamed(session):
    judgement = alignment.judge(session)
    assert judgement.aligned
    assert not judgement.better
    assert judgement.residual < 0.004


INVERTED = Conversion(poses_are="object-to-camera")


@pytest.mark.parametrize(
    ("session", "right"),
    [
        (BLOB, INVERTED),
        (BOX, INVERTED),
        (CENTERED, INVERTED),
        (BLOB, Conversion(pose_axes="RUB")),
        (CENTERED, Conversion(pose_axes="FLU")),
        (BOX, Conversion(pose_units="mm")),
        (BLOB, Conversion(pose_units="cm")),
        (BLOB, replace(INVERTED, pose_axes="RUB")),
        (BOX, replace(INVERTED, pose_axes="RUB", pose_units="mm")),
    ],
)
def test_wrong_poses_are_named_by_what_is_wrong(session, right):
    judgement = alignment.judge(misread(session, right))
    assert not judgement.aligned
    (better,) = judgement.better
    assert better.changes(judgement.given) == right.changes(Conversion())
    mended = misread(misread(session, right), judgement.given, judgement.better[0])
    assert alignment.judge(mended).aligned
    assert judgement.better_residual < judgement.residual / 1.5


def test_clouds_in_millimetres_with_poses_in_metres():
    views = [replace(view, points=view.points * 1000) for view in BLOB.views()]
    judgement = alignment.judge(in_memory(BLOB.info, views, BLOB.truth()))
    assert [reading.changes(judgement.given) for reading in judgement.better] == [{"units": "mm", "pose_units": "m"}]
    assert judgement.better_residual == pytest.approx(alignment.judge(BLOB).residual, rel=0.05)


def test_the_reading_that_was_used_is_the_one_that_is_judged():
    """A file rightly read by an option is not to be read by the same option again, nor by its default."""
    right = Conversion(poses_are="object-to-camera", axes="RUB", pose_axes="RUB", units="mm", pose_units="mm")
    assert alignment.judge(misread(BLOB, right, right)).aligned
    judgement = alignment.judge(misread(BLOB, replace(right, poses_are="camera-to-object"), right))
    assert [reading.changes(judgement.given) for reading in judgement.better] == [{"poses_are": "camera-to-object"}]


def test_what_cannot_be_told_is_not_claimed():
    """A ball that is turned about itself looks the same under every reading of the turn."""
    ball = orbit(sphere, centered=False)
    assert not alignment.judge(misread(ball, INVERTED)).better


@pytest.mark.parametrize("degrees", [3, 8])
def test_poses_with_errors_are_not_blamed_on_their_reading(degrees):
    rng = np.random.default_rng(degrees)
    truth = {}
    for i, T in BOX.truth().items():
        turn = Rotation.from_rotvec(np.deg2rad(degrees) * rng.normal(size=3) / np.sqrt(3)).as_matrix()
        truth[i] = poses.make(turn, rng.normal(size=3) * degrees / 2000) @ T
    judgement = alignment.judge(in_memory(BOX.info, list(BOX.views()), truth))
    assert not judgement.better
    assert judgement.residual > 0.002


def test_poses_of_something_else_are_apart():
    rng = np.random.default_rng(0)
    truth = {i: poses.make(T[:3, :3], T[:3, 3] + rng.normal(size=3)) for i, T in BLOB.truth().items()}
    judgement = alignment.judge(in_memory(BLOB.info, list(BLOB.views()), truth))
    assert judgement.apart
    assert not judgement.aligned
    assert not judgement.better


@pytest.mark.parametrize("step", [90, 180])
def test_views_that_hardly_overlap_are_not_judged(step):
    session = scan(n_views=2, step_deg=step)
    assert alignment.judge(session) is None


def test_too_few_poses_or_points_are_not_judged():
    assert alignment.judge(in_memory(BLOB.info, list(BLOB.views()), {3: np.eye(4)})) is None
    empty = [replace(view, points=view.points[:3]) for view in BLOB.views()]
    assert alignment.judge(in_memory(BLOB.info, empty, BLOB.truth())) is None


def test_a_long_session_is_judged_by_a_few_of_its_views():
    session, loaded = scan(n_views=60, step_deg=8, points=2000), []
    views = list(session.views())
    counting = replace(session, load=lambda i: (loaded.append(i), views[i])[1])
    assert alignment.judge(counting).aligned
    assert len(loaded) <= 2 * alignment.MAX_PAIRS


def test_there_are_24_right_handed_frames():
    axes = alignment.right_handed_axes()
    assert len(set(axes)) == 24
    assert {"RDF", "RUB", "RFU", "FLU"} < set(axes)


def test_the_bunny_as_given_and_inverted_by_hand(data, tmp_path):
    (bunny,) = open_capture(data / "stanford_bunny")
    judgement = alignment.judge(bunny)
    assert judgement.aligned
    assert judgement.residual < 0.001
    views = list(bunny.views())
    given = Conversion(axes="RUB", pose_axes="RUB")
    inverted = {i: given.pose(poses.invert(given.source_pose(T))) for i, T in bunny.truth().items()}
    judgement = alignment.judge(in_memory(bunny.info, views, inverted))
    assert [reading.changes(judgement.given) for reading in judgement.better] == [{"poses_are": "object-to-camera"}]
    assert judgement.residual > 0.01
    assert judgement.better_residual < 0.001
