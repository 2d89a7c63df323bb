"""Seconds count once: a stage inside another is not the other's."""

import time

import pytest

from orbitscan.processing.timing import Stopwatch, total


def test_a_stage_inside_another_is_not_counted_twice():
    watch = Stopwatch()
    started = time.perf_counter()
    with watch("refine", "refined"):
        time.sleep(0.02)
        with watch("prepare", "pairwise", "refined"):
            time.sleep(0.05)
    elapsed = time.perf_counter() - started
    lap = watch.lap()
    assert lap["pairwise"]["prepare"] == lap["refined"]["prepare"] >= 0.05
    assert lap["refined"]["refine"] >= 0.02
    assert sum(lap["refined"].values()) == pytest.approx(elapsed, abs=0.005)


def test_stages_add_up_over_laps_and_a_lap_begins_anew():
    watch = Stopwatch()
    with watch("icp", "icp"):
        pass
    laps = [watch.lap(), watch.lap()]
    assert laps[1] == {}
    laps = [{"icp": {"icp": 1.0}}, {"icp": {"icp": 2.0, "prepare": 4.0}, "session": {"outlier_removal": 0.5}}]
    sums = total(laps, ("icp",), 9.0)
    assert sums["methods"]["icp"]["icp"] == 3.0
    assert sums["methods"]["icp"]["total"] == 7.0
    assert (sums["outlier_removal"], sums["classification"], sums["total"]) == (0.5, 0.0, 9.0)


def test_a_shared_stage_counts_for_the_methods_that_use_it_and_alone_for_one():
    watch = Stopwatch(("icp", "pairwise", "refined"))
    for stage in ("prepare", "keypoints", "refine"):
        with watch.shared(stage):
            pass
    lap = watch.lap()
    assert {method: set(stages) for method, stages in lap.items()} == {
        "icp": {"prepare"},
        "pairwise": {"prepare", "keypoints", "refine"},
        "refined": {"prepare", "keypoints", "refine"},
    }
    with watch.alone("refine", "refined"), watch.shared("prepare"):
        pass
    assert {method: set(stages) for method, stages in watch.lap().items()} == {"refined": {"prepare", "refine"}}
    with watch.shared("prepare"):
        pass
    assert set(watch.lap()) == {"icp", "pairwise", "refined"}
