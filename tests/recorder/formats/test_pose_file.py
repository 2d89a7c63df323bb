"""Pose files of every kind hold the same poses."""

import json

import numpy as np
import pytest

from orbitscan.recorder import poses
from orbitscan.recorder.exceptions import InvalidPose
from orbitscan.recorder.formats import pose_file
from tests.geometry import random_pose

MOTIONS = [random_pose(np.random.default_rng(seed)) for seed in range(4)]


def rows(count, mark=" "):
    return [mark.join(repr(number) for number in T.ravel()[:count].tolist()) for T in MOTIONS]


def blocks():
    return "\n\n".join("\n".join(" ".join(map(repr, row)) for row in T.tolist()) for T in MOTIONS)


NAMED = {f"view_{i}": T.tolist() for i, T in zip((10, 2, 1, 0), MOTIONS, strict=True)}
FILES = {
    "kitti.txt": "\n".join(rows(12)),
    "rows.txt": "\n".join(rows(16)) + "\n",
    "rows.csv": "# a comment\n" + "\n".join(rows(16, ", ")),
    "blocks.txt": "# four by four\n" + blocks(),
    "tum.txt": "# stamp x y z\n" + "\n".join(poses.to_tum_line(500 * i, T) for i, T in enumerate(MOTIONS)),
    "list.json": json.dumps([T.tolist() for T in MOTIONS]),
    "flat.json": json.dumps({"poses": [T.ravel().tolist() for T in MOTIONS]}),
    "small.json": "\ufeff" + json.dumps([T[:3].tolist() for T in MOTIONS]),
    "no_suffix": json.dumps([T.tolist() for T in MOTIONS]),
}


@pytest.mark.parametrize("name", FILES)
def test_every_format_holds_the_same_poses(tmp_path, name):
    (tmp_path / name).write_text(FILES[name], encoding="utf-8")
    found = pose_file.read(tmp_path / name)
    np.testing.assert_allclose(np.stack(found.motions), MOTIONS, atol=1e-10)
    assert found.names is None
    assert found.stamps_ns == ((0, 500, 1000, 1500) if name == "tum.txt" else None)


@pytest.mark.parametrize("content", [NAMED, {"poses": NAMED}])
def test_names_come_in_natural_order(tmp_path, content):
    (tmp_path / "p.json").write_text(json.dumps(content))
    found = pose_file.read(tmp_path / "p.json")
    assert found.names == ("view_0", "view_1", "view_2", "view_10")
    np.testing.assert_array_equal(np.stack(found.motions), MOTIONS[::-1])


def test_an_unknown_pose_is_null(tmp_path):
    (tmp_path / "p.json").write_text(json.dumps([MOTIONS[0].tolist(), None]))
    assert pose_file.read(tmp_path / "p.json").motions[1] is None


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("p.txt", "", "lines of no numbers"),
        ("p.txt", "1 2 3\n", "lines of 3 numbers"),
        ("p.txt", rows(12)[0] + "\n" + rows(16)[0], "lines of 12 and 16 numbers"),
        ("p.txt", "1 0 0 0\n0 1 0 0\n0 0 1 0\n", "lines of 4 numbers"),
        ("p.txt", "one " * 12, "no number"),
        ("p.txt", "0 0 0 0 0 0 0 1\n\n# x\n1 0 0 0 0 0 0 9\n", r"p\.txt, line 4: a quaternion has the length 9"),
        ("p.txt", "-1 0 0 0 0 0 0 1\n", "the stamp -1 s"),
        ("p.json", "{", "is no JSON"),
        ("p.json", "3", "holds a int"),
        ("p.json", "[[1, 2, 3]]", r"p\.json, pose 0: is neither 4x4 nor 3x4"),
        ("p.json", '{"a": "left"}', "pose 'a': is neither 4x4 nor 3x4"),
        ("p.json", "[[[1, 2], [3]]]", "is neither 4x4 nor 3x4"),
    ],
)
def test_what_holds_no_poses_is_refused(tmp_path, name, text, what):
    (tmp_path / name).write_text(text)
    with pytest.raises(InvalidPose, match=what):
        pose_file.read(tmp_path / name)


def test_a_missing_file_and_a_folder_are_refused(tmp_path):
    for path in (tmp_path / "none.txt", tmp_path):
        with pytest.raises(InvalidPose, match="cannot be read"):
            pose_file.read(path)


def test_pose_files_are_found_by_their_names(tmp_path):
    theirs = ["Poses.txt", "a.tum", "camera_trajectory.csv", "ground_truth.json", "x.kitti"]
    for name in [*theirs, "README.txt", "pose.png", "calibration.json", "scan.csv"]:
        (tmp_path / name).touch()
    assert [path.name for path in pose_file.find(tmp_path)] == theirs
