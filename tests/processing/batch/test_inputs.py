"""What the commands take for recordings."""

import pytest

from orbitscan.processing.batch.inputs import find_recordings, find_unfinished
from orbitscan.recorder.exceptions import InvalidOption, UnreadableRecording


def test_folders_files_and_patterns_name_recordings_once(tmp_path):
    for name in ("b.mcap", "a.mcap", "in/c.mcap", "in/notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    a, b, c = tmp_path / "a.mcap", tmp_path / "b.mcap", tmp_path / "in" / "c.mcap"
    assert find_recordings([tmp_path]) == [a, b, c]
    assert find_recordings([b, tmp_path / "*.mcap"]) == [b, a]
    assert find_recordings([tmp_path / "**" / "*.mcap"]) == [a, b, c]
    assert find_recordings([tmp_path / "missing.mcap"]) == [tmp_path / "missing.mcap"]  # told when it is read
    for nothing in (tmp_path / "x*.mcap", tmp_path / "empty"):
        (tmp_path / "empty").mkdir(exist_ok=True)
        with pytest.raises(UnreadableRecording):
            find_recordings([nothing])


def test_a_name_with_brackets_is_a_file_where_there_is_one(tmp_path):
    (tmp_path / "mug[1].mcap").touch()
    assert find_recordings([tmp_path / "mug[1].mcap"]) == [tmp_path / "mug[1].mcap"]


@pytest.mark.parametrize("name", ["mug.part.mcap", "mug.part.old.mcap"])
def test_a_name_that_unfinished_results_have_is_refused(name, tmp_path):
    with pytest.raises(InvalidOption, match="rename it"):
        find_recordings([tmp_path / name])


def test_what_lies_in_results_is_no_input(tmp_path):
    for name in ("out/mug/registered.mcap", "out/mug/results.json", "out/cup.part/registered.mcap.part", "mug.mcap"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert find_recordings([tmp_path]) == find_recordings([tmp_path / "**" / "*.mcap"]) == [tmp_path / "mug.mcap"]
    registered = tmp_path / "out" / "mug" / "registered.mcap"
    assert find_recordings([registered]) == [registered]  # named itself
    assert find_unfinished([tmp_path]) == []


def test_what_convert_has_not_finished_is_found(tmp_path):
    (tmp_path / "mug.mcap.part").touch()
    assert find_unfinished([tmp_path, tmp_path / "other.mcap"]) == [tmp_path / "mug.mcap.part"]
