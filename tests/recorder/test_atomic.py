"""Files and folders appear whole or not at all."""

import pytest

from orbitscan.recorder.atomic import whole_file, whole_folder
from orbitscan.recorder.exceptions import UnwritableOutput


def test_a_folder_takes_the_place_of_the_old_one_when_it_is_whole(tmp_path):
    folder = tmp_path / "r"
    for content in ("first", "second"):
        with whole_folder(folder) as part:
            assert not list(part.iterdir())
            (part / "file").write_text(content)
            if content == "second":
                assert (folder / "file").read_text() == "first"
        assert (folder / "file").read_text() == content
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_a_block_that_raises_leaves_what_was_there(tmp_path):
    with whole_folder(tmp_path / "r") as part:
        (part / "file").write_text("first")

    def make_half():
        with whole_folder(tmp_path / "r") as part:
            (part / "other").write_text("half")
            raise ValueError("half")

    with pytest.raises(ValueError, match="half"):
        make_half()
    assert [path.name for path in (tmp_path / "r").iterdir()] == ["file"]
    assert [path.name for path in tmp_path.iterdir()] == ["r"]


def test_what_a_killed_process_left_is_removed(tmp_path):
    for name in ("r.part", "r.part.old"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "left").write_text("half")
    with whole_folder(tmp_path / "r") as part:
        (part / "file").write_text("whole")
    assert [path.name for path in tmp_path.iterdir()] == ["r"]
    assert [path.name for path in (tmp_path / "r").iterdir()] == ["file"]


def test_a_file_appears_whole(tmp_path):
    def make_half():
        with whole_file(tmp_path / "f") as part:
            part.write_text("half")
            raise ValueError("half")

    with pytest.raises(ValueError, match="half"):
        make_half()
    assert not list(tmp_path.iterdir())
    with whole_file(tmp_path / "f") as part:
        part.write_text("whole")
    assert (tmp_path / "f").read_text() == "whole"
    with pytest.raises(UnwritableOutput, match="cannot be written"), whole_file(tmp_path / "f" / "in a file") as part:
        part.write_text("x")
