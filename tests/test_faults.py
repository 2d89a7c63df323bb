"""One kill of those of `make faults`, and a full disk."""

import pytest

from tests.faults import fill_disk, kill_at_random


def test_a_killed_batch_goes_on_to_the_same_bytes(tmp_path):
    kill_at_random(tmp_path, sessions=3, kills=1, seed=0)


def test_a_full_disk_leaves_nothing_half_written(tmp_path):
    try:
        fill_disk(tmp_path, (2200,))
    except OSError as reason:
        pytest.skip(str(reason))
