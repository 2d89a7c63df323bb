"""A capture's format is recognised from what it holds, or the choices are told."""

import numpy as np
import pytest

from orbitscan.recorder.conversion import CaptureOptions
from orbitscan.recorder.exceptions import UnknownFormat
from orbitscan.recorder.sources import FORMATS, open_capture
from tests.recorder.sources.test_washington import write_frames


def test_nothing_there(tmp_path):
    with pytest.raises(UnknownFormat, match="no such file or folder"):
        open_capture(tmp_path / "nowhere")


def test_nothing_that_is_known_names_all_choices(tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    for source in (tmp_path, tmp_path / "notes.txt"):
        with pytest.raises(UnknownFormat) as caught:
            open_capture(source)
        assert all(name in str(caught.value) for name in FORMATS)


def test_an_unknown_format_by_name(tmp_path):
    with pytest.raises(UnknownFormat, match="format='e57': not a known format; give clouds, stanford, washington"):
        open_capture(tmp_path, CaptureOptions(format="e57"))


def test_frames_of_washington_beside_poses_could_be_two_formats(tmp_path):
    write_frames(tmp_path, "cap_1_1_1", "cap_1_1_2")
    assert open_capture(tmp_path)[0].info.source == "washington"
    (tmp_path / "poses.txt").write_text("\n".join(["1 0 0 0 0 1 0 0 0 0 1 0"] * 2))
    with pytest.raises(UnknownFormat, match="could be clouds or washington; say which with format"):
        open_capture(tmp_path)
    assert open_capture(tmp_path, CaptureOptions(format="clouds"))[0].info.source == "clouds"
    assert open_capture(tmp_path, CaptureOptions(format="washington"))[0].info.source == "washington"


def test_a_conf_among_clouds_is_stanford_s_only_where_it_places_scans(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((3, 3)))
    (tmp_path / "tool.conf").write_text("colour = blue\n")
    assert open_capture(tmp_path)[0].info.source == "clouds"


def test_a_tree_of_clouds_may_be_a_collection(tmp_path):
    for folder in (tmp_path / "bowl", tmp_path / "mug" / "red"):
        folder.mkdir(parents=True)
        np.save(folder / "a.npy", np.zeros((3, 3)))
    with pytest.raises(UnknownFormat, match=r"its folders do \(bowl, mug\); pass categories_from_folders=True where"):
        open_capture(tmp_path)


@pytest.mark.parametrize(
    ("name", "what"), [("a.mcap", "give it to 'orbitscan process'"), ("cup.stl", "scan it with 'orbitscan simulate'")]
)
def test_what_people_try(tmp_path, name, what):
    (tmp_path / name).write_bytes(b"x")
    with pytest.raises(UnknownFormat, match=what):
        open_capture(tmp_path / name)
