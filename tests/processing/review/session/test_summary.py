"""The review's summary: what cannot be told, what turned, and what helps."""

from dataclasses import replace

import numpy as np

from orbitscan.processing.reconstruction.coverage import Coverage, find_gaps
from orbitscan.processing.results.estimates import Symmetry
from orbitscan.processing.review.session import summary
from tests.processing.review.made_results import AXIS, CENTER, FAILED
from tests.processing.review.recordings import read_rows


def test_summary_says_what_cannot_be_told_and_what_turned(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "refined places 3 of 5 views with confidence; ambiguous: 3; too_few_points: 4. The loop is closed." in words
    assert "20.00° from view to view, the camera going counterclockwise seen from above" in words
    assert "leans 30.00° off the first view's upright" in words
    assert "slips by 0.2° (view 0), wobbles by 0.02° (view 2) and shifts by 0.2 mm (view 2)" in words
    assert "a turn about the axis (0.00, -0.87, -0.50) through (0, 0, 600) mm (view 3)" in words
    assert "`orbitscan process --step-deg N` uses your knowledge" in words
    assert "1 of 4 pairs are left out of the graph" in words
    assert "Off by 30°, by 0.25° with that granted" in words
    table = read_rows(reviewed[0], "/table", "TextDocument:text")["/table"][-1][0]
    assert "observable [deg]" in table


def test_the_remedy_is_not_named_again_where_it_was_used(reviewed):
    found = reviewed[1][1].reconstruction["refined"]
    assert "does not fit these views" in summary.describe_freedoms(found, step_was_given=True)
    held = replace(found, views=found.views[:FAILED], freedoms=())  # by other pairs: that one is free tells nothing
    assert summary.describe_freedoms(held, step_was_given=False) == ""


def test_bounds_of_ok_views_are_in_the_table_and_unchallenged_methods_have_a_dagger(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "| 0.15, 0.2 | 0.3, 0.4 |" in words  # median and largest of views 1 and 2
    assert "Within: the 95 % bounds of the ok views, median and largest." in words
    assert "| icp | 2 of 5 † |" in words
    assert "| refined | 2 of 5 |" in words
    assert "† unchecked against other poses" in words


def test_symmetries_the_step_and_notes_are_told(reviewed):
    session = reviewed[1][1]
    found = session.reconstruction["refined"]
    hexagon = Symmetry(AXIS, CENTER, 6)
    symmetric = replace(found, freedoms=(), symmetries=(hexagon,))
    text = summary.describe_symmetries(symmetric, step_was_given=False)
    assert text.startswith("**Symmetric in the first view's frame:** 6-fold about (0.00, -0.87, -0.50): turned by any")
    assert "(view 3). `orbitscan process --step-deg N`" in text
    assert "--step-deg" not in summary.describe_symmetries(symmetric, step_was_given=True)
    pairs = tuple(replace(p, freedoms=(), symmetries=(hexagon,)) if p.source == FAILED else p for p in found.pairs)
    of_pair = replace(found, freedoms=(), pairs=pairs)  # a method without a graph knows those of its pairs
    assert summary.describe_symmetries(of_pair, step_was_given=False).startswith("**Symmetric:** 6-fold about")
    settled = replace(
        found,
        views=tuple(replace(view, note="Looked at twice.") if view.view < 2 else view for view in found.views),
        pairs=tuple(replace(pair, start="step") if pair.target == pair.source - 1 else pair for pair in found.pairs),
    )
    words = summary.summarize(replace(session, reconstruction={"refined": settled}), ["refined"])
    assert "**By the user's step:** views 1, 2." in words
    assert "- views 0, 1: Looked at twice." in words


def test_the_azimuths_that_no_view_covers_are_in_words(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    said = "**Not covered:** no view between 40° and 360°. Azimuths are about the turntable's axis, counterclockwise"
    assert said in words


def test_gaps_are_named_widest_first_and_a_circle_is_covered():
    def write(*azimuths):
        found = dict(enumerate(azimuths))
        coverage = Coverage(np.array([0, 0, 1.0]), np.zeros(3), np.array([1.0, 0, 0]), found, find_gaps(found, 45.0))
        return summary.describe_coverage(coverage, on_turntable=False)

    some = write(0, 40, 80, 120, 160, 200, 250, 310)
    assert "no view between 250° and 310°; no view between 200° and 250°; no view between 310° and 360°. " in some
    assert "view 0 at 0°" in some
    assert "and 3 more such arcs" in write(0, 60, 120, 180, 240, 300)
    assert "between 350° and 50°" in write(50, 90, 130, 170, 210, 250, 290, 320, 350)
    assert write(*range(0, 360, 20)) == "**Covered all round:** neighbours stand at most 20° apart."


def test_what_is_wrong_comes_before_what_is_unsure(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    order = ["places 3 of 5", "| method |", "What is wrong, worst first", "**Turntable:**", "**Not covered:**"]
    assert [words.index(part) for part in order] == sorted(words.index(part) for part in order)
    assert "Move the time cursor to a view" in words
