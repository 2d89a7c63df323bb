"""A tree of folders becomes a session per cloud, its category the first folder's name."""

import numpy as np
import pytest

from orbitscan.recorder import cloud
from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose, UnknownFormat, UnreadableCloud
from orbitscan.recorder.sources import open_capture

LABELLED = CaptureOptions(categories_from_folders=True)
LIDAR = CaptureOptions(
    categories_from_folders=True, columns=("origin_x", "origin_y", "origin_z"), axes="LUF", scale=0.204
)


def plant(root, *files):
    """Clouds of one point each, (i, 10, 100) for the i-th."""
    for i, name in enumerate(files):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(f"{i} 10 100\n")
    return root


def test_each_cloud_is_a_session_labelled_by_its_first_folder(tmp_path):
    plant(tmp_path, "Coffee Mug/red.xyz", "bell-pepper/b 10.xyz", "bell-pepper/b 2.xyz", "cap/new/far/cap_7.xyz")
    sessions = open_capture(tmp_path, LABELLED)
    assert [(s.info.name, s.info.category, s.info.instance) for s in sessions] == [
        ("coffee_mug_red", "coffee_mug", "red"),
        ("bell_pepper_b_2", "bell_pepper", "b 2"),
        ("bell_pepper_b_10", "bell_pepper", "b 10"),
        ("cap_7", "cap", "cap_7"),
    ]
    for session, first in zip(sessions, (0, 2, 1, 3), strict=True):
        assert (session.info.views, session.info.capture, session.info.source) == (1, "unknown", "clouds")
        assert session.names == (session.info.instance,)
        np.testing.assert_array_equal(session.load(0).points, [[first, 10, 100]])
        assert not session.truth()


def test_names_that_would_be_the_same_are_told_apart_by_their_folders(tmp_path):
    plant(tmp_path, "cup/train/a.xyz", "cup/test/A.xyz", "cup/b.xyz", "fat/mug_1.xyz", "fat mug/fat_mug_1.xyz")
    names = {session.info.name for session in open_capture(tmp_path, LABELLED)}
    assert names == {"cup_train_a", "cup_test_A", "cup_b", "fat_mug_1", "fat_mug_fat_mug_1"}


def test_two_files_of_one_name_are_refused(tmp_path):
    plant(tmp_path, "cup/a.xyz", "cup/a.csv")
    with pytest.raises(UnknownFormat, match=r"holds cup/a\.(csv|xyz) and cup/a\.(csv|xyz); keep one of them"):
        open_capture(tmp_path, LABELLED)


@pytest.mark.parametrize("name", ["a..b.xyz", "Größe (3)*?.xyz", " a.xyz", 'a"b|c<d>.xyz'])
def test_names_can_be_files_everywhere(tmp_path, name):
    plant(tmp_path, f"cup:1/{name}")
    (session,) = open_capture(tmp_path, LABELLED)
    assert session.info.name.startswith("cup_1_")
    assert not set(session.info.name) & set('/\\:*?"<>| ')


def test_hidden_files_and_folders_without_clouds_are_left_out(tmp_path):
    plant(tmp_path, "cup/a.xyz", "cup/._a.xyz", ".cache/cup/a.xyz", "cup/.old/c.xyz", "docs/readme.md")
    assert [session.info.name for session in open_capture(tmp_path, LABELLED)] == ["cup_a"]


def test_the_conversion_holds_for_every_cloud(tmp_path):
    plant(tmp_path, "cup/a.xyz", "bowl/b.xyz")
    options = CaptureOptions(
        categories_from_folders=True, units="cm", scale=2, axes="RFU", sensor_origin=(0, -50.0, 100.0)
    )
    for session in open_capture(tmp_path, options):
        assert (session.info.source_axes, session.info.source_units) == ("RFU", "cm")
        assert session.info.sensor_origin == (0.0, -2.0, -1.0)
        np.testing.assert_allclose(session.load(0).points[0, 1:], [-2, 0.2], rtol=1e-6)
    unknown = CaptureOptions(categories_from_folders=True, sensor_origin="unknown")
    assert {session.info.sensor_origin for session in open_capture(tmp_path, unknown)} == {None}


@pytest.mark.parametrize(
    ("said", "what"),
    [
        ({"poses": "p.txt"}, "poses: is not for categories_from_folders, which makes a session of each view"),
        ({"poses_are": "object-to-camera"}, "poses_are: is not for"),
        ({"category": "cup"}, "category: the folders and files settle it; leave it out"),
        ({"name": "cup"}, "name: the folders and files settle it"),
        ({"axes": "RUF"}, "a left-handed frame"),
        ({"format": "washington"}, "categories_from_folders: the washington format settles it"),
    ],
)
def test_options_that_do_not_go_with_it_are_refused(tmp_path, said, what):
    plant(tmp_path, "cup/a.xyz")
    with pytest.raises(InvalidOption, match=what):
        open_capture(tmp_path, CaptureOptions(categories_from_folders=True, **said))


@pytest.mark.parametrize("name", ["poses.txt", "cup/truth.json", "cup/new/trajectory.csv"])
def test_poses_among_the_clouds_are_refused(tmp_path, name):
    plant(tmp_path, "cup/new/a.xyz", name)
    with pytest.raises(InvalidPose, match="may hold poses, but each view is a session of its own; move or rename it"):
        open_capture(tmp_path, LABELLED)


def test_what_is_no_tree_of_categories_is_refused(tmp_path):
    (tmp_path / "cup").mkdir()
    with pytest.raises(UnknownFormat, match=r"its folders hold no cloud file \(\.ply"):
        open_capture(tmp_path, LABELLED)
    plant(tmp_path, "cup/a.xyz", "loose.xyz")
    with pytest.raises(UnknownFormat, match=r"loose\.xyz: lies in no category's folder"):
        open_capture(tmp_path, LABELLED)
    with pytest.raises(UnknownFormat, match="is a file, not a folder of categories"):
        open_capture(tmp_path / "loose.xyz", LABELLED)


def test_a_tree_of_the_washington_data_set_may_be_labelled_by_its_folders(tmp_path):
    plant(tmp_path, "cap/cap_1_1_1.pcd")
    (session,) = open_capture(tmp_path, LABELLED)
    assert (session.info.source, session.info.category, session.info.instance) == ("clouds", "cap", "cap_1_1_1")
    with pytest.raises(UnreadableCloud):
        session.load(0)


def test_a_real_lidar_stands_upright_before_the_sensor_in_metres(data):
    sessions = open_capture(data / "lidarnet_v2", LIDAR)
    assert len(sessions) == len({session.info.name for session in sessions}) == 370
    counts = {c: sum(s.info.category == c for s in sessions) for c in ("bush", "car", "pedestrian", "trunk")}
    assert counts == {"bush": 79, "car": 54, "pedestrian": 67, "trunk": 170}
    points = {c: [s.load(0).points for s in sessions if s.info.category == c] for c in ("pedestrian", "car")}
    height = {c: np.median([np.ptp(p[:, 1]) for p in points[c]]) for c in points}
    assert 1.6 < height["pedestrian"] < 1.85
    assert 1.4 < height["car"] < 1.8
    feet = np.median([p[:, 1].max() for p in points["pedestrian"]])
    assert 1.5 < feet < 2.1  # below the sensor on its car: y points down
    assert np.mean([p[:, 2].mean() > 0 for p in points["car"]]) > 0.9
    rays = np.concatenate(points["pedestrian"] + points["car"])
    elevation_deg = np.degrees(np.arctan2(-rays[:, 1], np.hypot(rays[:, 0], rays[:, 2])))
    rings = elevation_deg / (4 / 3)  # an HDL-32E's lasers are 4/3 degrees apart, seen from its origin
    assert np.quantile(np.abs(rings - np.round(rings)), 0.99) < 0.02


def test_simulated_bowls_stand_upright_and_open_upwards(data):
    options = CaptureOptions(categories_from_folders=True, axes="FLU", sensor_origin="unknown")
    sessions = open_capture(data / "rug_restaurant20_gazebo", options)
    assert len(sessions) == 660
    bowls = [cloud.finite(s.load(0).points)[0] for s in sessions if s.info.category == "bowl"]
    for points in bowls:
        x, y, z = np.ptp(points, axis=0)
        assert y < 0.7 * min(x, z)
        assert points[np.argmax(np.hypot(points[:, 0], points[:, 2])), 1] < 0  # the wide rim is above the centre
