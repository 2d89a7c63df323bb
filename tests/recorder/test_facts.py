"""What is told of a recording: counts, sizes, and what is lost."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.recorder.exceptions import InvalidPose
from orbitscan.recorder.facts import gather_facts
from orbitscan.recorder.session import View, in_memory
from tests.geometry import scan

SESSION = scan(n_views=5, step_deg=30, points=6000)


def test_the_facts_of_a_scan():
    facts = gather_facts(SESSION)
    assert (facts.info, facts.names, facts.poses, facts.damage) == (SESSION.info, SESSION.names, 5, None)
    counts = [len(view.points) for view in SESSION.views()]
    assert facts.points == (min(counts), int(np.median(counts)), max(counts))
    assert facts.used == (0, 1, 2, 3, 4)
    assert 0 < facts.noise < facts.resolution < min(facts.extent) < max(facts.extent) < facts.distance


def test_what_is_lost_is_told():
    views = [SESSION.load(0), *(View(i, f"v{i}", i, np.empty((0, 3), np.float32), None, "lost") for i in (1, 2))]
    facts = gather_facts(replace(in_memory(SESSION.info, views), damage="the file is cut"))
    assert facts.damage == "the file is cut; views 1-2 unreadable"
    assert (facts.points[0], facts.poses) == (0, 0)
    assert np.isfinite(facts.resolution)


def test_nothing_is_measured_where_there_are_no_points():
    empty = in_memory(SESSION.info, [View(0, "v", 1, np.full((9, 3), np.nan, np.float32))])
    assert np.isnan([gather_facts(empty).noise, *gather_facts(empty).extent]).all()


def test_poses_that_cannot_be_read_are_a_fact():
    def broken():
        raise InvalidPose("s.mcap", "a quaternion has the length 0, not 1", "give a unit quaternion")

    facts = gather_facts(replace(SESSION, load_truth=broken))
    assert (facts.poses, facts.unreadable_poses) == (None, "a quaternion has the length 0, not 1")


def test_facts_do_not_change():
    with pytest.raises(AttributeError):
        gather_facts(SESSION).poses = 3
