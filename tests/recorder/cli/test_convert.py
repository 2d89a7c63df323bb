"""`convert`: what it writes, what it tells of wrong poses and options, how it ends."""

import json
import time

import numpy as np
import pytest

from orbitscan.recorder import mcap_file
from tests.recorder.cli.conftest import SESSION


def test_convert_tells_what_is_wrong_and_the_flag_mends_it(orbitscan, scans):
    status, out, err = orbitscan("convert", "scans", "-o", "mug.mcap")
    assert (status, err) == (1, "")
    assert out.splitlines()[0] == "mug.mcap: 5 views"
    assert "inverted; pass --poses-are object-to-camera" in out
    status, out, err = orbitscan("convert", "scans", "-o", "mug.mcap", "--poses-are", "object-to-camera")
    assert (status, err) == (0, "")
    assert "  info: poses align the views to" in out
    assert out.endswith("next: orbitscan check mug.mcap\nnext: orbitscan process mug.mcap -o results\n")
    found = mcap_file.read(scans.parent / "mug.mcap")
    assert (found.info.name, found.names[4]) == ("mug", "scan4")
    np.testing.assert_allclose(found.truth()[3], SESSION.truth()[3], atol=1e-9)


def test_convert_passes_every_option_on(orbitscan, scans):
    (scans / "poses.json").rename(scans.parent / "p.json")
    options = (
        "--format clouds --poses p.json --poses-are object-to-camera --units mm --pose-units cm --scale 2 --axes RUB "
        "--pose-axes FLU --sensor-origin -1000,0,500 --category coffee_mug --instance 7 --name cup"
    )
    orbitscan("convert", "scans", "-o", "mug.mcap", *options.split())
    info = mcap_file.read(scans.parent / "mug.mcap").info
    assert (info.name, info.category, info.instance, info.views) == ("cup", "coffee_mug", "7", 5)
    assert (info.source_axes, info.source_units, info.source_poses) == ("RUB", "mm", "object-to-camera FLU cm")
    assert info.sensor_origin == (-2.0, 0.0, -1.0)


def test_converting_twice_gives_the_same_bytes(orbitscan, scans):
    orbitscan("convert", "scans", "-o", "a/mug.mcap")
    orbitscan("convert", "scans", "-o", "b/mug.mcap")
    assert (scans.parent / "a/mug.mcap").read_bytes() == (scans.parent / "b/mug.mcap").read_bytes()


def test_convert_into_a_folder_names_the_file_after_the_session(orbitscan, scans):
    orbitscan("convert", "scans", "-o", "recordings")
    assert [path.name for path in (scans.parent / "recordings").iterdir()] == ["scans.mcap"]


def test_convert_makes_a_recording_for_each_session(orbitscan, data, tmp_path):
    source = data / "washington" / "rgbd-dataset"
    status, out, err = orbitscan("convert", source, "-o", "w")
    assert (status, err) == (0, "")
    assert out.splitlines()[2] == f"{tmp_path.joinpath('w/cap_1_1.mcap').relative_to(tmp_path)}: 38 views"
    assert out.endswith("next: orbitscan process w -o results\n")
    assert len(list((tmp_path / "w").iterdir())) == 6
    status, _, err = orbitscan("convert", source, "-o", "w.mcap")
    assert status == 2
    assert err == f"orbitscan: error: -o w.mcap: {source} holds 6 sessions; give a folder, such as -o recordings\n"


def test_a_session_that_fails_does_not_stop_the_others(orbitscan, tmp_path):
    pcd = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n0 0.7 0\n"
    (tmp_path / "tree").mkdir()
    for name, text in (("cap_1_1_1", pcd), ("mug_1_1_1", pcd[:-8]), ("pen_1_1_1", pcd)):
        (tmp_path / "tree" / f"{name}.pcd").write_text(text)
    status, _, err = orbitscan("convert", "tree", "-o", "w")
    assert status == 1
    assert err == (
        "orbitscan: error: tree/mug_1_1_1.pcd: no readable PCD cloud (it is cut: 0 of the 1 points it declares); "
        "copy it again or leave it out\n"
    )
    assert sorted(path.name for path in (tmp_path / "w").iterdir()) == ["cap_1_1.mcap", "pen_1_1.mcap"]


@pytest.fixture
def tree(tmp_path):
    """Three labelled clouds of 40 points, 0.2 m wide and 1 m before the sensor, y up as a LiDAR has them."""
    for i, stem in enumerate(("Mug/a", "Mug/deep/mug_2", "soup-bowl/b")):
        path = tmp_path / "tree" / f"{stem}.csv"
        path.parent.mkdir(parents=True, exist_ok=True)
        points = np.random.default_rng(i).uniform(-0.1, 0.1, (40, 3)) + np.array([0, 0, 1])
        np.savetxt(path, np.hstack([points, 0 * points]), delimiter=",", header="px,py,pz,qx,qy,qz", comments="")
    return tmp_path / "tree"


def test_convert_takes_categories_from_folders(orbitscan, tree):
    command = "convert tree -o c --categories-from-folders --columns px,py,pz --axes LUF"
    status, out, err = orbitscan(*command.split())
    assert (status, err) == (0, "")
    assert out == "c: 3 recordings (mug 2, soup_bowl 1)\nnext: orbitscan train c -o model.pt\n"
    found = [mcap_file.read(path) for path in sorted((tree.parent / "c").iterdir())]
    assert [(s.info.name, s.info.category, s.info.instance) for s in found] == [
        ("mug_2", "mug", "mug_2"),
        ("mug_a", "mug", "a"),
        ("soup_bowl_b", "soup_bowl", "b"),
    ]
    written = np.loadtxt(tree / "soup-bowl" / "b.csv", delimiter=",", skiprows=1)[:, :3]
    np.testing.assert_allclose(found[2].load(0).points, written * [-1, -1, 1], rtol=1e-6)


@pytest.mark.parametrize(
    ("options", "remedy"),
    [("--scale 1000 --axes LUF", "pass --units mm if these are millimetres"), ("--axes RUB", "pass --axes")],
)
def test_a_collection_with_wrong_options_is_told_of_once(orbitscan, tree, options, remedy):
    command = f"convert tree -o c --categories-from-folders --columns px,py,pz {options}"
    status, out, _ = orbitscan(*command.split())
    assert status == 1
    assert out.count("problem: ") == out.count(remedy) == 1


def test_a_cloud_of_a_collection_that_fails_does_not_stop_the_others(orbitscan, tree):
    (tree / "Mug" / "a.csv").write_text("px,py,pz\n1,2\n")
    command = "convert tree -o c --categories-from-folders --columns px,py,pz --axes LUF"
    status, out, err = orbitscan(*command.split())
    assert status == 1
    assert err.startswith("orbitscan: error: tree/Mug/a.csv: no readable CSV cloud (")
    assert err.count("\n") == 1
    assert out.startswith("c: 2 recordings (mug 1, soup_bowl 1)\n")


def test_many_small_recordings_are_written_quickly(orbitscan, tmp_path):
    for i in range(200):
        (tmp_path / "many" / f"c{i % 4}").mkdir(parents=True, exist_ok=True)
        np.save(tmp_path / "many" / f"c{i % 4}" / f"{i}.npy", np.random.default_rng(i).normal(size=(500, 3)))
    start = time.process_time()
    assert orbitscan("convert", "many", "-o", "c", "--categories-from-folders", "--sensor-origin", "unknown")[0] == 0
    assert time.process_time() - start < 200 * 0.02


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (
            "convert tree -o x",
            "tree: holds no cloud itself, but its folders do (Mug, soup-bowl); pass --categories-from-folders where",
        ),
        (
            "convert tree -o x --categories-from-folders",
            "tree/Mug/a.csv: may hold its points in px,py,pz and qx,qy,qz; pass --columns px,py,pz",
        ),
        ("convert tree -o x --columns px,py", "--columns px,py: not three names; write those of x, y and z"),
        ("convert tree -o x --columns px,px,pz", "--columns px,px,pz: not three names; write those of x, y and z"),
        ("convert tree -o x --categories-from-folders --columns px,py,up", "--columns px,py,up: tree/Mug/a.csv has no"),
        ("convert tree -o x --categories-from-folders --poses p.txt", "--poses: is not for --categories-from-folders"),
        ("convert tree -o x.mcap --categories-from-folders", "-o x.mcap: tree holds 3 sessions; give a folder, such"),
    ],
)
def test_a_collection_that_cannot_be_converted_is_told_in_one_line(orbitscan, tree, arguments, sentence):
    status, out, err = orbitscan(*arguments.split())
    assert (status, out) == (2, "")
    assert err.startswith(f"orbitscan: error: {sentence}")
    assert err.count("\n") == 1
    assert not list(tree.parent.rglob("*.mcap*"))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("convert nowhere -o x.mcap", "nowhere: no such file or folder; name a folder of PLY, PCD, XYZ or NPY clouds"),
        (
            "convert scans -o x.mcap --poses none.txt",
            "none.txt: cannot be read (No such file or directory); check --poses",
        ),
        ("convert scans -o x.mcap --poses short.json", "short.json: holds 1 poses for 5 clouds; give a pose for each"),
        ("convert scans -o x.mcap --poses bent.json", "bent.json, pose of scan0.npy: a pose is not a rotation"),
        ("convert scans -o x.mcap --axes RUF", "axes 'RUF': a left-handed frame; name where x, y and z point"),
        ("convert scans -o x.mcap --scale 0", "--scale 0: not a positive number; give metres per unit of the source"),
        (
            "convert scans -o x.mcap --sensor-origin 1,2",
            "--sensor-origin 1,2: neither X,Y,Z nor 'unknown'; write 0,0,0",
        ),
        ("convert scans -o x.mcap --name ../up", "--name ../up: not a file name; give one without slashes"),
        ("convert scans -o scans/poses.json", "scans/poses.json/scans.mcap: cannot be written"),
        (
            "convert scans/broken.ply -o x.mcap",
            "scans/broken.ply: no readable PLY cloud (it does not start with 'ply')",
        ),
        ("convert blob.mcap -o x.mcap", "blob.mcap: is a recording already; give it to 'orbitscan process'"),
        ("info none.mcap", "none.mcap: no such file; name a recording (.mcap)"),
        ("check scans", "scans: is a folder; name a recording (.mcap)"),
        ("check empty.mcap", "empty.mcap: the file is empty; make a recording with 'orbitscan convert'"),
        ("info short.json", "short.json: not an MCAP file; make a recording with 'orbitscan convert'"),
        ("simulate nobody -o x.mcap", "nobody"),
        ("simulate bowl -o x.mcap --instances 3", "--instances 3: is not for bowl"),
        ("simulate bowl -o x.mcap --every 0", "--every 0: not a step"),
        ("simulate corpus -o x --instance 3", "--instance 3: is not for corpus"),
        ("simulate corpus -o x --elevation 3", "--elevation 3: is not for corpus"),
        ("simulate corpus -o x --instances 0", "--instances 0: a category has at least one"),
        ("simulate corpus -o x.mcap", "-o x.mcap: 183 recordings do not fit one file"),
    ],
)
def test_wrong_input_is_told_in_one_line(orbitscan, scans, recording, arguments, sentence):
    (scans.parent / "empty.mcap").touch()
    (scans.parent / "short.json").write_text(json.dumps([np.eye(4).tolist()]))
    (scans.parent / "bent.json").write_text(json.dumps([(2 * np.eye(4)).tolist()[:3]] * 5))
    (scans.parent / "broken.ply").write_text("solid")
    (scans.parent / "broken.ply").rename(scans / "broken.ply")
    if "broken" not in arguments:
        (scans / "broken.ply").unlink()
    status, out, err = orbitscan(*arguments.split())
    assert (status, out) == (2, "")
    assert err.startswith(f"orbitscan: error: {sentence}")
    assert err.count("\n") == 1
    assert not (scans.parent / "x.mcap").exists()
    assert not list(scans.parent.rglob("*.part"))
