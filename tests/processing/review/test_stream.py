"""A recording has an identity that every viewer takes, and the name that its user gave it."""

import re

import pytest
import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from orbitscan.processing.review.stream import whole_recording
from tests import viewer
from tests.processing.review.recordings import read_all


def write(folder, name):
    path = folder / "recording.rrd"
    with whole_recording(path, name, rrb.Blueprint(rrb.TextDocumentView(origin="/word"))) as stream:
        stream.log("/word", rr.TextDocument("a word"), static=True)
    return path


@pytest.mark.usefixtures("renderer")
@pytest.mark.parametrize("name", ["tasse☕", "größe", "mug.2", "a b/c", "☕", "plain-name_1"])
def test_any_name_is_shown_as_it_is_and_drawn(name, tmp_path, capfd):
    path = write(tmp_path, name)
    with viewer.open_viewer(path) as client:
        assert viewer.find_reports(client) == []
    assert "WARN" not in "".join(capfd.readouterr())


@pytest.mark.parametrize("name", ["tasse☕", "größe", "mug.2"])
def test_the_identity_is_a_slug_and_the_name_is_kept(name, tmp_path):
    path = write(tmp_path, name)
    (entry,) = RrdReader(path).recordings()
    assert re.fullmatch(r"[A-Za-z0-9_-]+", entry.application_id)
    assert entry.recording_id == entry.application_id
    assert read_all(path, "/__properties/**", "RecordingInfo:name") == [name]


def test_a_plain_name_is_the_identity_and_other_names_have_others(tmp_path):
    names = ("mug", "größe", "gr-e", "grösse", "mug.2", "mug-2")
    entries = [RrdReader(write(tmp_path, name)).recordings()[0].application_id for name in names]
    assert entries[0] == "orbitscan-mug"
    assert len(set(entries)) == len(names)
