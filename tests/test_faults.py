"""One kill as those of `make faults`, and one full disk."""

import os

import pytest
from filelock import FileLock

from tests.faults import NoSmallDisk, fill_disk, kill_half_way, prepare


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """Recordings and the results of an undisturbed batch: made once in a run, by one of its processes."""
    folder = tmp_path_factory.getbasetemp()
    folder = (folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder) / "faults"
    folder.mkdir(exist_ok=True)
    with FileLock(folder / "lock"):
        prepare(folder, sessions=3)
    return folder


def test_a_killed_batch_goes_on_to_the_same_bytes(work):
    kill_half_way(work, sessions=3)


def test_a_full_disk_leaves_nothing_half_written(work):
    try:
        fill_disk(work, (2200,))
    except NoSmallDisk as reason:
        pytest.skip(str(reason))
