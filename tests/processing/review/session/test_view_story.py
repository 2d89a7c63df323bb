"""A view's story: in the recording at the view's own time; the funnel, starts and why they lost, errors, pairs."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.results.estimates import Candidate, PairErrors, ViewErrors, ViewEstimate
from orbitscan.processing.results.status import METHODS, Status
from orbitscan.processing.review.session.view_story import Seen, tell
from tests.processing.review.made_results import EMPTY, FAILED, make_pair, make_results
from tests.processing.review.recordings import read_rows

SEEN = Seen(17, "frame_170", 21_345, None, None, (16, 90, 40))


def row_of(story: str, first: str) -> list[str]:
    """The cells of the table row that begins with these words."""
    return next(
        [c.strip() for c in line.split("|")[1:-1]] for line in story.splitlines() if line.startswith(f"| {first} |")
    )


def failed_pair(**fields):
    starts = (Candidate("consensus 1", Status.LOW_OVERLAP, 0.41), Candidate("previous", Status.INCONSISTENT, -0.2))
    return replace(make_pair(17, 16, Status.LOW_OVERLAP, True, 2000), candidates=starts, start="consensus 1", **fields)


def test_the_funnel_goes_from_points_to_overlap():
    pair = failed_pair(confidence=0.12)
    pair = replace(pair, evidence=replace(pair.evidence, overlap=0.08))
    story = tell(
        SEEN, {"pairwise": ViewEstimate(17, Status.LOW_OVERLAP, np.eye(4))}, {"pairwise": [pair]}, finished=True
    )
    assert story.startswith("## View 17 (frame_170)")
    assert "21,345 points." in story
    assert "**pairwise: low_overlap (too little of the surface lies on the earlier view).** Against view 16" in story
    head = row_of(story, "by")
    cells = dict(zip(head, row_of(story, "pairwise"), strict=True))
    funnel = ["points", "keypoints", "valid frames", "matches", "inliers", "overlap"]
    assert [cells[name] for name in funnel] == ["2,000", "300", "290", "90", "40", "8%"]
    assert [head.index(name) for name in funnel] == sorted(head.index(name) for name in funnel)
    assert "residual [mm]" in head
    assert "view 16: 40 of 90 matches are inliers" in story


def test_each_start_says_why_it_lost():
    story = tell(
        SEEN, {"pairwise": ViewEstimate(17, Status.LOW_OVERLAP, None)}, {"pairwise": [failed_pair()]}, finished=True
    )
    assert "; not placed" in story
    assert (
        row_of(story, "consensus 1")[2] == "was chosen all the same: too little of the surface lies on the earlier view"
    )
    assert row_of(story, "previous") == ["previous", "-0.2", "lost: a surface would be seen through another"]


def test_a_start_that_also_holds_agrees_less():
    starts = (Candidate("identity", Status.OK, 0.8), Candidate("previous", Status.OK, 0.79))
    pair = replace(make_pair(17, 16, Status.OK, True, 2000), candidates=starts, start="identity")
    story = tell(SEEN, {"pairwise": ViewEstimate(17, Status.OK, np.eye(4))}, {"pairwise": [pair]}, finished=True)
    assert row_of(story, "identity")[2] == "was chosen"
    assert row_of(story, "previous")[2] == "would hold too, but the surfaces agree less"


def test_errors_have_their_units():
    errors = ViewErrors(0.012, 0.5, 20.4, 0.003)
    pair = failed_pair(errors=PairErrors(30.0, 0.01, 0.25, 0.001))
    estimates = {
        "icp": ViewEstimate(17, Status.OK, np.eye(4), errors=errors),
        "pairwise": ViewEstimate(17, Status.OK, np.eye(4)),
    }
    story = tell(SEEN, estimates, {"icp": [pair]}, finished=True)
    errors_at = story[story.index("### Errors") :]
    assert row_of(errors_at, "by")[1:5] == ["translation [mm]", "chordal [0 to 2.83]", "angle [deg]", "centre [mm]"]
    assert row_of(errors_at, "icp")[1:] == ["12", "0.5", "20.4", "3", "30", "0.25"]


def test_how_well_a_view_is_known_and_its_note_are_told():
    estimate = ViewEstimate(17, Status.OK, np.eye(4), 0.25, 0.002, "The rest of it.")
    pair = replace(make_pair(17, 16, Status.OK, True, 2000), margin=31.4, start="step")
    story = tell(SEEN, {"refined": estimate}, {"refined": [pair]}, finished=True)
    assert "**refined: ok.** The rest of it. Known within 0.25° and 2 mm (95 %). Against view 16" in story
    assert (
        "The next candidate explains the views worse by 31.4 standard deviations. Placed by the user's step." in story
    )


def test_a_damaged_view_says_so():
    story = tell(replace(SEEN, points=0, damage="its chunk is damaged", matched=None), {}, {}, finished=False)
    assert "**Not readable:** its chunk is damaged." in story
    assert "not finished" in story


def test_the_recording_tells_each_view_at_its_time_when_all_is_known(reviewed):
    path, (views, _) = reviewed
    stories = {view: cell[0] for view, cell in read_rows(path, "/story", "TextDocument:text")["/story"].items()}
    assert sorted(stories) == [result.view for result in views]
    assert not [story for story in stories.values() if "not finished" in story]
    assert "All others are placed in its frame" in stories[0]
    failed = stories[FAILED]
    assert "**refined: ambiguous" in failed
    assert "Free: a turn about the axis" in failed
    assert "The others: pairwise low_overlap" in failed
    assert row_of(failed[failed.index("### Errors") :], "refined")[-2:] == ["30", "0.25"]
    assert "not placed" in stories[EMPTY]
    assert "0 points" in stories[EMPTY]
    others = stories[2][stories[2].index("### Its other pairs") :]
    assert row_of(others, "0")[-1] == "left out: the others contradict it"
    assert row_of(others, "3")[-1] == "ambiguous"


@pytest.mark.parametrize("method", METHODS[:3])
def test_what_a_view_leaves_before_the_end_is_not_finished(method):
    views, _ = make_results()
    result = views[FAILED]
    pairs = {name: (pair,) for name, pair in result.pairs.items()}
    story = tell(Seen.of(result), result.poses, pairs, finished=False)
    assert "not finished" in story
    assert row_of(story, method)[1] == "low_overlap"
