import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from orbitscan.recorder import mcap_file, poses
from orbitscan.recorder.exceptions import InvalidOption, UnreadableCloud
from orbitscan.recorder.mesh import Mesh
from orbitscan.recorder.simulation import objects
from orbitscan.recorder.simulation.box_tree import BoxTree
from orbitscan.recorder.simulation.camera import Camera, simulate
from orbitscan.recorder.simulation.objects.solids import box


def write_mesh(path: Path, mesh: Mesh) -> str:
    """Write a mesh file; returns its name as a command line has it."""
    trimesh.Trimesh(mesh.vertices, mesh.triangles, vertex_colors=mesh.colors, process=False).export(path)
    return str(path)


def beside_the_surface(mesh: Mesh, T_object_camera: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far a view's points lie from where their rays first meet the mesh [m]; inf where they meet nothing."""
    rays = poses.rotate(T_object_camera, points)
    first = BoxTree(mesh).cast(T_object_camera[:3, 3], rays, 0).distance
    return np.abs(first - 1) * np.linalg.norm(rays, axis=1)


@pytest.fixture
def plate(tmp_path):
    """The file of a plate 40 cm wide and 2 cm high that stands on z = 0."""
    return write_mesh(tmp_path / "plate.stl", box(0.4, 0.4, 0.02))


def test_the_robot_at_the_defaults_is_a_sample_worth_its_name():
    session = simulate("robot")
    views = list(session.views())
    assert [view.index for view in views] == list(range(18))
    assert min(len(view.points) for view in views) >= 10_000
    assert session.info.views == len(session.names) == len(session.truth()) == 18
    assert (session.info.name, session.info.category, session.info.instance) == ("robot", "robot", "1")
    assert (session.info.source, session.info.capture, session.info.sensor_origin) == ("virtual", "circle", (0, 0, 0))
    assert (session.info.elevation_deg, session.info.views_per_turn) == (30, 18)
    for view in views:
        assert view.points.dtype == np.float32
        assert view.colors.shape == view.points.shape
        assert view.colors.dtype == np.uint8
        assert np.isfinite(view.points).all()


@pytest.mark.parametrize("name", objects.names())
def test_without_noise_every_point_is_where_its_ray_first_meets_the_surface(name):
    session = simulate(name, views=4, noise_mm=0)
    mesh, truth = objects.build(name), session.truth()
    for view in session.views():
        assert len(view.points) > 100
        assert beside_the_surface(mesh, truth[view.index], view.points).max() < 1e-4


@settings(max_examples=15, deadline=None)
@given(st.integers(1, 60), st.floats(-90, 90), st.floats(0.5, 4))
def test_the_cameras_stand_in_equal_steps_on_a_circle_and_look_at_the_centre(views, elevation_deg, distance):
    truth = simulate("robot", views=views, elevation_deg=elevation_deg, distance=distance).truth()
    center = np.array([0, 0, objects.build("robot").bounds[1][2] / 2])
    step = 2 * math.pi / views
    turn = poses.make([[math.cos(step), -math.sin(step), 0], [math.sin(step), math.cos(step), 0], [0, 0, 1]], [0, 0, 0])
    elevation = math.radians(elevation_deg)
    first = center + distance * np.array([math.cos(elevation), 0, math.sin(elevation)])
    np.testing.assert_allclose(truth[0][:3, 3], first, atol=1e-12)
    for index, T_object_camera in truth.items():
        poses.check(T_object_camera, f"view {index}")
        np.testing.assert_allclose(
            poses.transform(T_object_camera, np.array([[0, 0, distance]]))[0], center, atol=1e-12
        )
        assert T_object_camera[2, 0] == pytest.approx(0, abs=1e-12)  # x is level
        assert T_object_camera[2, 1] <= 0  # y points down
        np.testing.assert_allclose(truth[(index + 1) % views], turn @ T_object_camera, atol=1e-11)


def test_one_object_is_seen_as_large_as_its_focal_length_and_distance_say(plate):
    for focal, distance in [(525, 1.0), (1050, 1.0), (1050, 2.0)]:
        view = simulate(plate, views=1, elevation_deg=90, noise_mm=0, focal=focal, distance=distance + 0.01).load(0)
        assert len(view.points) == pytest.approx((0.4 * focal / distance) ** 2, rel=0.02)
        np.testing.assert_allclose(view.points[:, 2], distance, atol=1e-5)
        np.testing.assert_allclose(np.abs(view.points[:, :2]).max(axis=0), 0.2, atol=distance / focal)


def test_a_long_focal_length_gives_dense_clouds():
    assert len(simulate("robot", focal=1200).load(0).points) > 90_000


@pytest.mark.parametrize("distance", [1.0, 1.5, 2.0])
def test_the_noise_is_gaussian_along_the_ray_and_grows_with_the_square_of_depth(plate, distance):
    view = simulate(plate, views=1, elevation_deg=90, focal=800, distance=distance + 0.01, noise_mm=1.5).load(0)
    exact = simulate(plate, views=1, elevation_deg=90, focal=800, distance=distance + 0.01, noise_mm=0).load(0)
    error = (view.points[:, 2] - exact.points[:, 2]).astype(np.float64) / (0.0015 * distance**2)
    n = len(error)
    assert n > 20_000
    assert abs(error.mean()) < 4 / math.sqrt(n)
    assert abs(error.std() - 1) < 4 / math.sqrt(2 * n)
    assert np.mean(np.abs(error) < 1) == pytest.approx(0.6827, abs=0.015)
    np.testing.assert_allclose(np.cross(view.points, exact.points), 0, atol=1e-6)


def points_on_top(plate: str, elevation_deg: float) -> int:
    session = simulate(plate, views=1, elevation_deg=elevation_deg, distance=20, focal=10_000, noise_mm=0)
    placed = poses.transform(session.truth()[0], session.load(0).points)
    return int(np.sum((placed[:, 2] > 0.0199) & (np.abs(placed[:, :2]) < 0.199).all(axis=1)))


@pytest.mark.parametrize(("incidence_deg", "share"), [(0, 1), (50, 1), (64, 1), (72.5, 0.5), (77, 0.2), (81, 0)])
def test_surfaces_seen_at_a_grazing_angle_are_lost_little_by_little(plate, incidence_deg, share):
    pixels = (0.398 * 10_000 / 20) ** 2 * math.cos(math.radians(incidence_deg))
    assert points_on_top(plate, 90 - incidence_deg) / pixels == pytest.approx(share, abs=0.03)


def test_a_view_depends_on_the_seed_and_its_index_alone():
    whole = list(simulate("coffee_mug", views=6, seed=3).views())
    alone = simulate("coffee_mug", views=6, seed=3).load(5)
    np.testing.assert_array_equal(alone.points, whole[5].points)
    np.testing.assert_array_equal(alone.colors, whole[5].colors)
    other = simulate("coffee_mug", views=6, seed=4).load(5)
    assert other.points.shape != alone.points.shape or np.abs(other.points - alone.points).max() > 0
    error = [view.points[:500, 2] - view.points[:500, 2].mean() for view in whole[:2]]
    assert abs(np.corrcoef(*error)[0, 1]) < 0.99


def test_the_same_command_twice_writes_the_same_bytes(tmp_path):
    for name in ("first.mcap", "second.mcap"):
        mcap_file.write(simulate("robot", views=3), tmp_path / name)
    assert (tmp_path / "first.mcap").read_bytes() == (tmp_path / "second.mcap").read_bytes()


def test_a_recording_keeps_the_session(tmp_path):
    session = simulate("bin", instance=2, views=3)
    mcap_file.write(session, tmp_path / "bin.mcap")
    recorded = mcap_file.read(tmp_path / "bin.mcap")
    assert recorded.info == session.info
    assert recorded.info.name == "bin_2"
    for view in recorded.views():
        np.testing.assert_array_equal(view.points, session.load(view.index).points)
        np.testing.assert_allclose(recorded.truth()[view.index], session.truth()[view.index], atol=1e-12)


def test_a_mesh_file_is_seen_in_its_own_frame_and_colour(tmp_path):
    mesh = box(0.3, 0.2, 0.1).moved(5, -2, 1).painted((200, 100, 0))
    session = simulate(write_mesh(tmp_path / "crate.ply", mesh), views=5, noise_mm=0)
    assert (session.info.name, session.info.category, session.info.instance) == ("crate", None, None)
    for view in session.views():
        assert beside_the_surface(mesh, session.truth()[view.index], view.points).max() < 1e-4
        assert (view.colors[:, 2] == 0).all()
        assert (
            np.abs(view.colors[:, 0] - 2.0 * view.colors[:, 1]).max() <= 1
        )  # the light changes the value, not the hue
        assert view.colors[:, 0].max() <= 200


def test_a_mesh_without_colours_gives_none_and_its_distance_follows_its_size(plate, tmp_path):
    assert simulate(plate, views=2).load(0).colors is None
    large = box(2, 2, 2)
    camera = simulate(write_mesh(tmp_path / "large.obj", large), views=1).truth()[0][:3, 3]
    assert np.linalg.norm(camera - (0, 0, 1)) == pytest.approx(2.5 * math.sqrt(3))


def test_the_side_of_a_triangle_that_faces_the_camera_does_not_matter(tmp_path):
    mesh = box(0.3, 0.2, 0.1).painted((200, 100, 0))
    inside_out = Mesh(mesh.vertices, mesh.triangles[:, ::-1], mesh.colors)
    views = [simulate(write_mesh(tmp_path / f"{i}.ply", m), views=1).load(0) for i, m in enumerate((mesh, inside_out))]
    np.testing.assert_array_equal(views[0].colors, views[1].colors)


def test_a_camera_is_given_whole_or_by_its_fields():
    camera = Camera(views=8, every=2)
    session = simulate("bowl", 2, camera, seed=3)
    assert (session.info.name, session.info.views, session.info.views_per_turn) == ("bowl_2", 4, 4)
    same = simulate("bowl", instance=2, views=8, every=2, seed=3)
    assert (same.info, same.truth()[3].tolist()) == (session.info, session.truth()[3].tolist())
    with pytest.raises(TypeError, match="colour"):
        simulate("bowl", colour="red")


def test_views_are_rendered_only_when_loaded():
    session = simulate("robot", views=100_000)
    assert session.names[-1] == "view_99999"
    assert session.load(99_999).index == 99_999


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"views": 0}, "views=0: a turn has at least one view"),
        ({"noise_mm": -1}, "noise_mm=-1: not a standard deviation"),
        ({"noise_mm": math.nan}, "noise_mm=nan: not a standard deviation"),
        ({"elevation_deg": 90.5}, "elevation_deg=90.5: not an elevation"),
        ({"distance": 0.2}, "distance=0.2: the camera would stand inside the object"),
        ({"distance": math.inf}, "distance=inf: not a distance"),
        ({"focal": 0}, "focal=0: not a focal length"),
        ({"focal": 50_000}, "focal=50000: the object would fill an image of"),
        ({"sensor": "lidar"}, "sensor='lidar': not a known sensor; give gaussian or kinect"),
        ({"seed": -1}, "seed=-1: seeds are not negative"),
        ({"instance": 0}, "instance 0: instances count from 1"),
    ],
)
def test_values_that_make_no_sense_are_refused_in_one_sentence(options, sentence):
    with pytest.raises(InvalidOption) as error:
        simulate("robot", **options)
    assert str(error.value).startswith(sentence)
    assert "\n" not in str(error.value)


def test_a_word_that_is_no_object_is_answered_with_the_objects():
    with pytest.raises(InvalidOption, match="teapot: not a known object; choose one of bin, coffee_mug, robot"):
        simulate("teapot")


PLY = """ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
{vertex}
3 0 1 {index}
"""


@pytest.mark.parametrize(
    ("name", "content", "problem"),
    [
        ("missing.stl", None, "no such file"),
        ("empty.stl", "", "holds no triangles"),
        ("words.ply", "not a mesh", "holds no triangles"),
        ("words.xyz", "0 0 0", "holds no triangles"),
        ("nan.ply", PLY.format(vertex="0 nan 0", index=2), "a vertex is not finite"),
        ("index.ply", PLY.format(vertex="0 1 0", index=9), "a triangle names a vertex that is not there"),
        ("point.ply", PLY.format(vertex="1 0 0", index=2).replace("0 0 0\n", "1 0 0\n"), "measures 0 m across"),
        ("millimetres.ply", PLY.format(vertex="0 300 0", index=2), "measures 300 m across"),
    ],
)
def test_a_file_that_holds_no_mesh_is_refused_in_one_sentence(tmp_path, name, content, problem):
    path = tmp_path / name
    if content is not None:
        path.write_text(content)
    with pytest.raises(UnreadableCloud, match=problem) as error:
        simulate(str(path))
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)


def test_a_folder_is_no_mesh(tmp_path):
    with pytest.raises(UnreadableCloud, match="is a folder"):
        simulate(str(tmp_path))
