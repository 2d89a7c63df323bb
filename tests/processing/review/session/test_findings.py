"""What is not in order, in words: pairs that the graph leaves out, other poses as good."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.results.edges import count_edges, left_out
from orbitscan.processing.results.estimates import Candidate, Symmetry, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.processing.review.session.findings import describe_starts, explain, list_joint_findings
from orbitscan.recorder import poses
from tests.processing.review.made_results import make_pair
from tests.processing.review.recordings import read_all, read_rows


def test_a_view_is_spoken_for_by_its_best_edge_that_nothing_contradicts(reviewed):
    found = reviewed[1][1].reconstruction["refined"]
    assert {view: pair.target for view, pair in found.speaking.items()} == {1: 0, 2: 1, 3: 2}
    assert count_edges(found.pairs) == {0: 1, 1: 2, 2: 2, 3: 1}
    curve = read_rows(reviewed[0], "/evidence/edges/**", "Scalars:scalars")["/evidence/edges/refined"]
    assert curve == {0: [1.0], 1: [2.0], 2: [2.0], 3: [1.0]}


def test_an_edge_that_the_graph_leaves_out_is_a_line_of_the_log(reviewed):
    path, (_, session) = reviewed
    ((pair, disagreement),) = left_out(session.reconstruction["refined"])
    assert (pair.source, pair.target) == (2, 0)
    assert disagreement.degrees == pytest.approx(90)
    assert disagreement.metres == pytest.approx(0, abs=1e-9)  # the quarter turn is about the line of sight
    findings = [text for view, _, text in list_joint_findings(session) if view == 2]
    assert findings == [
        next(text for text in findings if "pair 2 to 0 is left out: the others contradict it by 90°" in text)
    ]
    assert findings[0] in read_all(path, "/log", "TextLog:text")


def test_alternatives_are_named_by_their_turn():
    half_turn = poses.from_quaternion(np.zeros(3), [0, 1, 0, 0], "")
    pair = replace(make_pair(1, 0, Status.AMBIGUOUS, True, 2000), alternatives=(half_turn,))
    assert "As good when turned by 180°" in explain(ViewEstimate(1, Status.AMBIGUOUS, np.eye(4)), pair)


def test_an_ambiguous_view_that_leaves_nothing_open_is_known_too_badly():
    pair = replace(make_pair(1, 0, Status.AMBIGUOUS, True, 2000), rotation_bound_deg=7.2, center_bound_m=0.003)
    view = ViewEstimate(1, Status.AMBIGUOUS, np.eye(4))
    assert explain(view, pair).startswith("ambiguous: known only within 7.2° and 3 mm (95 %). Against view 0")
    worse = replace(view, rotation_bound_deg=12.0, center_bound_m=0.004)  # over a chain of pairs
    assert "known only within 12° and 4 mm" in explain(worse, replace(pair, status=Status.OK))
    hexagon = Symmetry(np.array([0.0, -0.87, -0.5]), np.zeros(3), 6)
    open_ = explain(view, replace(pair, symmetries=(hexagon,)))
    assert "known only" not in open_
    assert "Symmetric: 6-fold about (0.00, -0.87, -0.50): turned by any multiple of 60° it looks the same" in open_


def test_notes_and_margins_are_told():
    pair = replace(make_pair(1, 0, Status.AMBIGUOUS, True, 2000), margin=31.0)
    text = explain(ViewEstimate(1, Status.AMBIGUOUS, np.eye(4), note="The step does not fit."), pair)
    assert ". The step does not fit. Against view 0" in text
    assert "The next candidate explains the views worse by 31 standard deviations" in text


def test_starts_of_one_fate_are_told_together():
    low = Status.LOW_OVERLAP
    fates = (("previous", Status.OK, 0.8), ("a", low, 0.3), ("identity", Status.OK, 0.2), ("b", low, -0.1))
    candidates = tuple(Candidate(*fate) for fate in fates)
    pair = replace(make_pair(1, 0, Status.OK, True, 2000), candidates=candidates, start="previous")
    assert describe_starts(pair) == (
        "previous (score 0.8) was chosen; "
        "a (score 0.3), b (score -0.1) lost: too little of the surface lies on the earlier view; "
        "identity (score 0.2) would hold too, but the surfaces agree less"
    )
    assert "would hold" in describe_starts(replace(pair, start=None))
