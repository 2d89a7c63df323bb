"""What metadata say is believed only where nothing speaks against it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.records import Metadata
from mcap_protobuf.writer import Writer

from orbitscan.recorder import mcap_file
from orbitscan.recorder.mcap_file import writing
from orbitscan.recorder.mcap_file.metadata import believe, seal
from tests.recorder.mcap_file.session import assert_same, assert_same_view, make_session

SAMPLE = Path(__file__).parents[3] / "recordings" / "robot.mcap"


def unsealed(name, entries, **others):
    """As the first version of the format had it."""
    return {**entries, "format_version": "1", **others} if name == "scan_session" else dict(entries)


def change(path, old, new):
    content = path.read_bytes()
    assert old in content
    path.write_bytes(content.replace(old, new, 1))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"0.125 0 -10", b"0.125 0 +10"),  # the sensor behind the object: every normal would turn
        (b"coffee_mug", b"coffee_muf"),
        (b"views\x01\x00\x00\x006", b"views\x01\x00\x00\x005"),
        (b"crc32", b"crc33"),
        (b"elevation_deg\x02", b"elevation_deg\x03"),
    ],
)
def test_damaged_facts_are_lost_and_not_believed(recording, old, new):
    change(recording, old, new)
    found, session = mcap_file.read(recording), make_session()
    assert "the facts of the session are lost" in found.damage
    assert (found.info.sensor_origin, found.info.category, found.info.elevation_deg) == (None, None, None)
    assert found.names == session.names
    for view in session.views():
        assert_same_view(found.load(view.index), view)
    assert set(found.truth()) == set(range(6))


def test_damaged_names_are_lost_and_not_believed(recording):
    change(recording, b"scan090", b"scan091")
    found = mcap_file.read(recording)
    assert "the names of the views are lost" in found.damage
    assert found.names == tuple(f"view_{i:03d}" for i in range(6))
    assert found.info == make_session().info
    np.testing.assert_array_equal(found.load(2).points, make_session().load(2).points)


def test_a_recording_without_crc_is_believed(recording, monkeypatch):
    monkeypatch.setattr(writing, "seal", unsealed)
    mcap_file.write(make_session(), recording)
    with recording.open("rb") as stream:
        assert all("crc32" not in record.metadata for record in make_reader(stream).iter_metadata())
    assert_same(mcap_file.read(recording), make_session())


def test_the_sample_is_whole():
    found = mcap_file.read(SAMPLE)
    assert found.damage is None
    assert (found.info.name, found.info.views, len(found.truth())) == ("robot", 18, 18)


def test_entries_in_another_order_are_the_same():
    entries = seal("scan_views", {"0": "a", "1": "b", "10": "c"})
    shuffled = dict(sorted(entries.items(), reverse=True))
    assert believe([Metadata("scan_views", shuffled)]) == {"scan_views": {"10": "c", "1": "b", "0": "a"}}


@pytest.mark.parametrize(
    "changed",
    [{"0": "a", "1": "B"}, {"0": "a"}, {"0": "a", "1": "b", "2": ""}, {"0": "a1", "": "b"}, {"0": "b", "1": "a"}],
)
def test_changed_entries_are_not_believed(changed):
    crc = seal("scan_views", {"0": "a", "1": "b"})["crc32"]
    assert believe([Metadata("scan_views", {**changed, "crc32": crc})]) == {}
    assert believe([Metadata("scan_session", {"0": "a", "1": "b", "crc32": crc})]) == {}


def test_a_damaged_record_gives_way_to_a_copy_of_it():
    sealed = seal("scan_views", {"0": "a"})
    assert believe([Metadata("scan_views", {**sealed, "0": "b"}), Metadata("scan_views", sealed)])["scan_views"] == {
        "0": "a"
    }


def test_records_of_others_are_not_ours_to_judge():
    others = Metadata("calibration", {"crc32": "as they like", "fx": "525"})
    ours = Metadata("scan_session", {"format_version": "1"}), Metadata("scan_views", {"0": "a"})
    assert set(believe([others, *ours])) == {"calibration", "scan_session", "scan_views"}


@pytest.mark.parametrize("start", [20, 48, 60, 120, 300])
def test_facts_in_a_long_stretch_of_zeros_are_not_believed(recording, start):
    """The CRCs are in it, too, and what is left looks like the metadata of a writer without."""
    content = recording.read_bytes()
    begin, end = content.index(b"scan_session"), content.index(b"scan000") + 200
    recording.write_bytes(content[: begin + start] + bytes(end - begin - start) + content[end:])
    found = mcap_file.read(recording)
    assert (found.info.category, found.info.sensor, found.info.sensor_origin) == (None, "", None)
    assert "the facts of the session and the names of the views are lost" in found.damage


@pytest.mark.parametrize("views", ["1000000000", "1e300", "-3", "many"])
def test_a_number_of_views_that_cannot_be_is_not_believed(tmp_path, monkeypatch, views):
    monkeypatch.setattr(writing, "seal", lambda name, entries: unsealed(name, entries, views=views))
    mcap_file.write(make_session(), tmp_path / "s.mcap")
    found = mcap_file.read(tmp_path / "s.mcap")
    assert (found.info.views, len(found.names)) == (6, 6)


def test_a_rewritten_recording_is_read(recording, tmp_path):
    """Other tools sort the entries and put several messages into a chunk."""
    with recording.open("rb") as source, (tmp_path / "anew.mcap").open("wb") as target:
        reader, writer = make_reader(source), Writer(target)._writer
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, dict(sorted(record.metadata.items())))
        summary = reader.get_summary()
        schemas = {s.id: writer.register_schema(s.name, s.encoding, s.data) for s in summary.schemas.values()}
        channels = {
            c.id: writer.register_channel(c.topic, c.message_encoding, schemas[c.schema_id])
            for c in summary.channels.values()
        }
        for _, _, m in reader.iter_messages():
            writer.add_message(channels[m.channel_id], m.log_time, m.data, m.publish_time, m.sequence)
        writer.finish()
    with (tmp_path / "anew.mcap").open("rb") as stream:
        assert len(make_reader(stream).get_summary().chunk_indexes) == 1
    found = mcap_file.read(tmp_path / "anew.mcap")
    assert_same(found, replace(make_session(), damage=None))
    assert found.damage is None
