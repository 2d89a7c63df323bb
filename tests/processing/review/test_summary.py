"""The review's summary: what cannot be told, what turned, and what helps."""

from dataclasses import replace

from processing.review import summary
from tests.processing.review.made_results import FAILED
from tests.processing.review.recordings import read_rows


def test_summary_says_what_cannot_be_told_and_what_turned(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "refined places 3 of 5 views with confidence; ambiguous: 3; too_few_points: 4. The loop is closed." in words
    assert "20.00° from view to view, the camera going counterclockwise seen from above" in words
    assert "leans 30.00° off the first view's upright" in words
    assert "slips by 0.2° (view 0), wobbles by 0.02° (view 2) and shifts by 0.2 mm (view 2)" in words
    assert "a turn about the axis (0.00, -0.87, -0.50) through (0, 0, 600) mm (view 3)" in words
    assert "`--step-deg N` uses your knowledge" in words
    assert "1 of 4 pairs are left out of the graph" in words
    assert "Off by 30°, by 0.25° with that granted" in words
    table = read_rows(reviewed[0], "/table", "TextDocument:text")["/table"][-1][0]
    assert "observable [deg]" in table


def test_the_remedy_is_not_named_again_where_it_was_used(reviewed):
    found = reviewed[1][1].reconstruction["refined"]
    assert "does not fit these views" in summary.describe_freedoms(found, step_was_given=True)
    held = replace(found, views=found.views[:FAILED], freedoms=())  # by other pairs: that one is free tells nothing
    assert summary.describe_freedoms(held, step_was_given=False) == ""
