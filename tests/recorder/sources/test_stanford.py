"""A Stanford .conf places its scans, in its own convention."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from orbitscan.recorder import poses
from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import InvalidOption, InvalidPose, UnknownFormat, UnreadableCloud
from orbitscan.recorder.sources import open_capture

BUNNY = ("bun000", "bun045", "bun090", "bun180", "bun270", "top2", "top3", "bun315", "chin", "ear_back")
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n"
)


@pytest.fixture
def folder(tmp_path):
    for name in ("b.ply", "a.ply"):
        (tmp_path / name).write_text(PLY)
    return tmp_path


def write_conf(folder, *lines):
    (folder / "scan.conf").write_text("\r\n".join(["camera 0 0 -1 0 0 0 1", *lines, ""]))
    return folder


def test_the_order_is_the_conf_s_and_absent_meshes_are_skipped(folder):
    write_conf(folder, "bmesh b.ply 0 0 0 0 0 0 1", "mesh merged.ply 0 0 0 0 0 0 1", "", "bmesh a.ply 0 0 0 0 0 0 1")
    for source in (folder, folder / "scan.conf"):
        (session,) = open_capture(source, CaptureOptions(category="bunny"))
        assert (session.names, session.info.name, session.info.category) == (("b", "a"), "scan", "bunny")
        assert (session.info.capture, session.info.sensor_origin) == ("unordered", (0.0, 0.0, -10.0))
        np.testing.assert_array_equal(session.load(0).points, [[1, -2, -3]])


def test_the_rotation_is_written_inverted_and_the_translation_is_not(folder):
    half = np.sqrt(0.5)
    write_conf(folder, f"bmesh a.ply 10 20 30 0 0 {half} {half}")  # a quarter turn about z
    (session,) = open_capture(folder)
    placed = poses.transform(session.truth()[0], session.load(0).points)
    np.testing.assert_allclose(placed, [[10 + 2, 20 - 1, 30 + 3]], atol=1e-6)


@pytest.mark.parametrize(
    ("line", "error", "what"),
    [
        ("bmesh c.ply 0 0 0 0 0 0 1", UnreadableCloud, r"c\.ply: no such file, but scan\.conf places it"),
        ("bmesh a.ply 0 0 0 0 0 1", InvalidPose, r"scan\.conf, line 2: 6 numbers after the file, not 7"),
        ("bmesh a.ply 0 0 0 0 0 0 one", InvalidPose, r"scan\.conf, line 2: a word that is no number"),
        ("bmesh a.ply 0 0 0 0 0 0 2", InvalidPose, r"scan\.conf, line 2: a quaternion has the length 2"),
    ],
)
def test_lines_that_make_no_sense_are_refused(folder, line, error, what):
    with pytest.raises(error, match=what):
        open_capture(write_conf(folder, line))


def test_two_confs_are_refused_until_one_is_named(folder):
    write_conf(folder, "bmesh a.ply 0 0 0 0 0 0 1")
    (folder / "other.conf").write_text("bmesh b.ply 0 0 0 0 0 0 1\n")
    with pytest.raises(UnknownFormat, match=r"other\.conf and scan\.conf; name one"):
        open_capture(folder)
    assert open_capture(folder / "other.conf")[0].names == ("b",)


def test_what_the_format_settles_is_not_up_to_the_user(folder):
    write_conf(folder, "bmesh a.ply 0 0 0 0 0 0 1")
    with pytest.raises(InvalidOption, match="axes: the stanford format settles it"):
        open_capture(folder, CaptureOptions(axes="RDF"))


def test_the_bunny_keeps_its_ten_scans_in_order(data):
    (session,) = open_capture(data / "stanford_bunny")
    assert session.names == BUNNY
    assert session.info.name == "bun"
    assert [len(view.points) for view in session.views()][:3] == [40256, 40097, 30379]
    assert sorted(session.truth()) == list(range(10))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("bun000", "bun045"),
        ("bun045", "bun000"),
        ("bun045", "top3"),
        ("bun090", "bun045"),
        ("top2", "bun180"),
        ("top2", "ear_back"),
        ("chin", "bun315"),
        ("chin", "bun000"),
        ("ear_back", "bun180"),
    ],
)
def test_the_bunny_s_poses_align_what_overlaps(data, one, other):
    """The wrong sign of the quaternion still looks right on bun000 and bun180, never on these."""
    (session,) = open_capture(data / "stanford_bunny")
    i, j = BUNNY.index(one), BUNNY.index(other)
    T_j_i = poses.invert(session.truth()[j]) @ session.truth()[i]
    distances, _ = cKDTree(session.load(j).points).query(poses.transform(T_j_i, session.load(i).points[::20]))
    near = distances < 0.003
    assert near.mean() > 0.5
    assert np.sqrt((distances[near] ** 2).mean()) < 0.001
