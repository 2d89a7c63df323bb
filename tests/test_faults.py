"""One kill of those of `make faults`, and one full disk."""

import pytest

from tests.faults import NoSmallDisk, fill_disk, kill_at_random


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """Where the recordings and the results of an undisturbed batch are, for both."""
    return tmp_path_factory.mktemp("work")


def test_a_killed_batch_goes_on_to_the_same_bytes(work):
    kill_at_random(work, sessions=3, kills=1, seed=0)


def test_a_full_disk_leaves_nothing_half_written(work):
    try:
        fill_disk(work, (2200,))
    except NoSmallDisk as reason:
        pytest.skip(str(reason))
