"""What is lost of a damaged file is said, and nothing else is lost."""

import struct
import time

import numpy as np
import pytest

from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import ScanError, UnreadableRecording
from orbitscan.recorder.session import SessionInfo, View, in_memory
from tests.fuzz.mutations import find_records
from tests.recorder.mcap_file.session import assert_same, assert_same_view, cloud_offsets, damage_chunk, make_session


@pytest.mark.parametrize("lost", [0, 2, 5])
def test_a_flipped_bit_costs_one_view(recording, lost):
    damage_chunk(recording, cloud_offsets(recording)[lost])
    session, truth = make_session(), make_session().truth()
    found = mcap_file.read(recording)
    for view in session.views():
        if view.index == lost:
            assert "damaged" in found.load(lost).damage
            assert len(found.load(lost).points) == 0
        else:
            assert_same_view(found.load(view.index), view)
    assert set(found.truth()) == set(truth)


@pytest.mark.parametrize("share", [0.3, 0.5, 0.8])
def test_a_cut_file_gives_the_views_before_the_cut(recording, share):
    offsets = cloud_offsets(recording)
    content = recording.read_bytes()
    cut = int(len(content) * share)
    recording.write_bytes(content[:cut])
    found, session = mcap_file.read(recording), make_session()
    assert found.info == session.info
    assert found.names == session.names
    assert "cut" in found.damage
    whole = [i for i, (offset, length) in enumerate(offsets) if offset + length <= cut]
    assert 0 < len(whole) < 6
    for view in session.views():
        if view.index in whole:
            assert_same_view(found.load(view.index), view)
        else:
            assert "missing" in found.load(view.index).damage


def test_a_file_that_its_writer_left_open_is_read(recording):
    part = recording.with_name("mug.mcap.part")
    part.write_bytes(recording.read_bytes()[: cloud_offsets(recording)[3][0]])
    found = mcap_file.read(part)
    assert found.info.name == "mug"
    assert [found.load(i).damage is None for i in range(6)] == [True] * 3 + [False] * 3


def test_a_bit_flipped_anywhere_costs_at_most_the_view_it_is_in(recording):
    offsets = cloud_offsets(recording)
    content = recording.read_bytes()
    session = make_session()
    rng = np.random.default_rng(0)
    positions = [*rng.integers(0, len(content), 150), *range(0, 700, 11), *range(len(content) - 1200, len(content), 17)]
    refused = 0
    for position in positions:
        flipped = bytearray(content)
        flipped[position] ^= 1 << int(rng.integers(8))
        recording.write_bytes(flipped)
        hit = [i for i, (offset, length) in enumerate(offsets) if offset <= position < offset + length]
        try:
            found = mcap_file.read(recording)
            views = [found.load(i) for i in range(6)]
            truth = found.truth()
        except ScanError:
            refused += 1
            assert position < 8, f"the recording is refused for a bit at {position}"
            continue
        assert len(found.names) == 6, f"views appear for a bit at {position}"
        for view in views:
            if view.index not in hit:
                np.testing.assert_array_equal(view.points, session.load(view.index).points, f"bit at {position}")
                np.testing.assert_array_equal(view.colors, session.load(view.index).colors, f"bit at {position}")
            elif view.damage is None:
                np.testing.assert_array_equal(view.points, session.load(view.index).points, f"bit at {position}")
        for i, T in truth.items():
            np.testing.assert_allclose(T, session.truth()[i], atol=1e-12)
        assert len(truth) >= 5
    assert refused < 5


def test_bytes_behind_the_end_cost_nothing(recording):
    recording.write_bytes(recording.read_bytes() + b"\x00" * 50)
    found, session = mcap_file.read(recording), make_session()
    for view in session.views():
        assert_same_view(found.load(view.index), view)


def swap(content, first, second):
    """The file with two records, of (start, end), in each other's place."""
    (a, b), (c, d) = sorted([first, second])
    return content[:a] + content[c:d] + content[b:c] + content[a:b] + content[d:]


def chunks(content):
    """Start and end of the chunks: a pose and a cloud for each view."""
    return [(start, end) for start, end in find_records(content) if content[start] == 0x06]


@pytest.mark.parametrize("pair", [(0, 1), (0, 2), (0, 10), (1, 3), (5, 9), (2, 4)])
def test_views_and_poses_in_each_other_s_place_are_found_again(recording, pair):
    content = recording.read_bytes()
    found = chunks(content)
    recording.write_bytes(swap(content, *(found[i] for i in pair)))
    assert_same(mcap_file.read(recording), make_session())
    assert "damaged" in mcap_file.read(recording).damage


@pytest.mark.parametrize("pair", [(1, 3), (2, 4)])
def test_views_of_one_size_and_one_time_are_not_taken_for_each_other(tmp_path, pair):
    """Then nothing in the index tells their chunks apart."""
    points = np.random.default_rng(0).permutation(np.arange(300, dtype=np.float32)).reshape(100, 3)
    views = [View(i, f"v{i}", 5, points + np.float32(1000 * i)) for i in range(3)]
    turned = [np.eye(4)[:, [0, 2, 1, 3]] * [[1], [-1], [1], [1]], np.eye(4)]
    session = in_memory(SessionInfo("s", 3), views, {i: turned[i % 2] for i in range(3)})
    mcap_file.write(session, tmp_path / "s.mcap")
    content = (tmp_path / "s.mcap").read_bytes()
    found = chunks(content)
    (tmp_path / "s.mcap").write_bytes(swap(content, *(found[i] for i in pair)))
    read = mcap_file.read(tmp_path / "s.mcap")
    for view in read.views():
        assert view.damage or np.array_equal(view.points, session.load(view.index).points)
    for i, T in read.truth().items():
        np.testing.assert_allclose(T, session.truth()[i], atol=1e-12)


def test_a_view_that_was_moved_behind_the_index_is_found(recording):
    """The index is full of what looks like chunks of absurd sizes."""
    content = recording.read_bytes()
    for start, end in chunks(content)[4:6]:
        recording.write_bytes(content[:start] + content[end:-37] + content[start:end] + content[-37:])
        found = mcap_file.read(recording)
        assert [view.damage for view in found.views()] == [None] * 6
        assert set(found.truth()) == set(range(6))


def test_a_pose_without_its_view_and_without_facts_is_no_trouble(recording):
    content = recording.read_bytes()
    recording.write_bytes(content[: chunks(content)[4][1]].replace(b"coffee_mug", b"coffee_jug"))
    found = mcap_file.read(recording)
    assert [view.damage is None for view in found.views()] == [True, True, False]
    assert set(found.truth()) == {0, 1, 2}


@pytest.mark.parametrize("change", [(0, b"/kamera"), (14 + 4, b"protobu ")])
def test_a_damaged_summary_that_tells_of_other_messages_is_not_believed(recording, change):
    content = recording.read_bytes()
    at, new = content.rindex(b"/camera/points") + change[0], change[1]  # the channel in the summary
    damaged = bytearray(content[:at] + new + content[at + len(new) :])
    start, end = chunks(content)[1]  # the chunk that declares the channel
    damaged[(start + end) // 2] ^= 1
    recording.write_bytes(damaged)
    found = mcap_file.read(recording)
    assert [view.damage is None for view in found.views()] == [False] + [True] * 5


def test_a_record_twice_is_one(recording):
    content = recording.read_bytes()
    for start, end in chunks(content)[2:4]:
        recording.write_bytes(content[:end] + content[start:end] + content[end:])
        assert_same(mcap_file.read(recording), make_session())


@pytest.mark.parametrize("lost", [1, 8, 100])
def test_a_file_whose_start_is_lost_gives_all_its_views(recording, lost):
    recording.write_bytes(recording.read_bytes()[lost:])
    found = mcap_file.read(recording)
    assert "damaged at its start" in found.damage
    for view in make_session().views():
        np.testing.assert_array_equal(found.load(view.index).points, view.points)


def test_views_are_known_without_the_record_that_declares_them(recording):
    damage_chunk(recording, cloud_offsets(recording)[0])  # the first of a topic declares it, and the summary does
    content = bytearray(recording.read_bytes()[:-200])
    content[chunks(content)[0][0] + 60] ^= 1  # so does the first pose
    recording.write_bytes(content)
    found, session = mcap_file.read(recording), make_session()
    assert found.load(0).damage
    for i in range(1, 6):
        assert_same_view(found.load(i), session.load(i))
    assert set(found.truth()) == set(range(1, 6))


def test_a_chunk_that_lost_its_crc_is_not_believed(recording):
    content = bytearray(recording.read_bytes())
    start, end = chunks(content)[3]
    content[start + 33 : start + 37] = bytes(4)
    content[end - 40] ^= 1
    recording.write_bytes(content)
    found = mcap_file.read(recording)
    assert [view.index for view in found.views() if view.damage] == [1]


def test_a_recording_of_which_no_view_is_left_is_refused(recording):
    content = recording.read_bytes()
    recording.write_bytes(content[: chunks(content)[0][1]])
    with pytest.raises(UnreadableRecording, match=r"no view can be read \(the file is cut or damaged at its end\)"):
        mcap_file.read(recording)


HEAD = struct.pack("<BQQQQII", 6, 0, 1, 1, 100, 1, 4) + b"zstd"  # of a chunk, without the length of its data


@pytest.mark.parametrize(
    "rubbish",
    [
        (HEAD + struct.pack("<Q", 1_900_000)) * 40_000,  # each tells that the rest of the file is in it
        struct.pack("<I", 12) + b"scan_session",
        (struct.pack("<I", 12) + b"scan_session" + struct.pack("<I", 900_000)) * 50_000,
        struct.pack("<I", 12) + b"scan_session" + struct.pack("<I", 2_000_000) + bytes(2_000_000),
        (b"\x0c" + struct.pack("<Q", 0)) * 200_000,
    ],
)
def test_a_search_ends_soon_whatever_the_file_is_made_of(recording, rubbish):
    content = recording.read_bytes()
    end = chunks(content)[-1][1]
    recording.write_bytes(content[:end] + rubbish + bytes(1_000_000) + content[end:])
    started = time.process_time()
    found = mcap_file.read(recording)
    assert time.process_time() - started < 3
    for view in make_session().views():
        assert_same_view(found.load(view.index), view)
