"""What is lost of a damaged file is said, and nothing else is lost."""

import numpy as np
import pytest

from recorder import mcap_file
from recorder.exceptions import ScanError
from tests.recorder.mcap_file.session import assert_same_view, cloud_offsets, damage_chunk, make_session


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
