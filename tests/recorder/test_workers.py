"""Work in other processes: every result comes back, and who leaves early waits for nobody."""

import os
import time
from concurrent.futures.process import BrokenProcessPool

import pytest

from orbitscan.recorder.workers import as_ready


def work(number):
    if number == 13:
        os._exit(1)
    if number < 0:
        raise ValueError(f"{number} is negative")
    time.sleep(number)
    return 2 * number


def test_each_item_comes_with_what_became_of_it():
    found = {item: future.exception() or future.result() for item, future in as_ready(work, (0.1, -1, 0.2), 2)}
    assert (found[0.1], found[0.2], str(found[-1])) == (0.2, 0.4, "-1 is negative")


def test_who_leaves_early_ends_what_is_under_way():
    began = time.monotonic()
    results = as_ready(work, (0, 600, 600), 2)
    assert next(results)[0] == 0
    results.close()
    assert time.monotonic() - began < 60


def test_a_worker_that_dies_is_told_by_the_futures():
    with pytest.raises(BrokenProcessPool):
        [future.result() for _, future in as_ready(work, (13,), 1)]
