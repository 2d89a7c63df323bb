"""The review's classification: curves, the answer in words, views that alone say otherwise; nothing without it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from orbitscan.processing.results.classification import SessionClassification, ViewClassification
from orbitscan.processing.results.status import METHODS
from orbitscan.processing.review import entities
from orbitscan.processing.review.session.classification import (
    conclude,
    describe_classification,
    describe_view,
    list_dissent,
    shown_categories,
)
from orbitscan.processing.review.session.recording import SessionReview
from tests import viewer
from tests.processing.review.made_results import EMPTY, Results, make_info, make_results, true_poses
from tests.processing.review.recordings import contrast, packed, read_all, read_rows

CATEGORIES = ("bowl", "cap", "coffee_mug", "pliers")
VIEWS = [  # probabilities of each view alone, and its score; the last of the five views has no points
    ((0.10, 0.05, 0.84, 0.01), 3.0),
    ((0.62, 0.05, 0.30, 0.03), 2.0),  # says bowl
    ((0.41, 0.19, 0.39, 0.01), -1.0),  # unknown
    ((0.80, 0.05, 0.12, 0.03), 2.5),  # says bowl, and worse
]


@pytest.fixture(scope="module")
def reviewed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Results]:
    path = tmp_path_factory.mktemp("review") / "review.rrd"
    return path, write_review(path)


def classify(values: Sequence[tuple[Sequence[float], float]] = VIEWS, known: bool = True) -> SessionClassification:
    """A session's classification: each view as given, fused by the mean."""
    views = []
    for i, (row, score) in enumerate(values):
        likeliest = CATEGORIES[int(np.argmax(row))]
        probabilities = dict(zip(CATEGORIES, row, strict=True))
        views.append(
            ViewClassification(i, likeliest if score > 0 else None, likeliest, score > 0, score, probabilities)
        )
    rows = np.cumsum([row for row, _ in values], axis=0) / np.arange(1, len(values) + 1)[:, None]
    best = CATEGORIES[int(rows[-1].argmax())]
    return SessionClassification(
        model="0" * 64,
        categories=CATEGORIES,
        category=best if known else None,
        likeliest=best,
        known=known,
        probability=float(rows[-1].max()),
        fused=tuple(dict(zip(CATEGORIES, row.tolist(), strict=True)) for row in rows),
        entropy=tuple(float(-(row * np.log(row)).sum()) for row in rows),
        views=tuple(views),
    )


def make_classified(category: str | None = "coffee_mug", found: SessionClassification | None = None) -> Results:
    found = found or classify()
    views, session = make_results()
    views = [replace(view, classification=shown) for view, shown in zip(views, found.views, strict=False)] + views[-1:]
    return views, replace(session, info=replace(session.info, category=category), classification=found)


def write_review(path: Path, category: str | None = "coffee_mug") -> Results:
    views, session = make_classified(category)
    info = replace(make_info(len(views)), category=category)
    with SessionReview(path, info, METHODS, true_poses(len(views))) as review:
        for result in views:
            review.add_view(result)
        review.add_session(session)
    return views, session


def test_curves_read_back_equal_the_results(reviewed):
    path, (views, session) = reviewed
    found = session.classification
    expected = {f"/classification/{c}": {v.view: [v.probabilities[c]] for v in found.views} for c in CATEGORIES}
    expected |= {
        f"/classification/fused/{c}": {v.view: [row[c]] for v, row in zip(found.views, found.fused, strict=True)}
        for c in CATEGORIES
    }
    expected["/classification/entropy"] = {
        v.view: [entropy] for v, entropy in zip(found.views, found.entropy, strict=True)
    }
    assert read_rows(path, "/classification/**", "Scalars:scalars") == expected
    assert len(views) - 1 == EMPTY == len(found.views)


def test_a_category_has_one_colour_and_the_true_one_is_thick(reviewed):
    colors = read_rows(reviewed[0], "/classification/**", "SeriesLines:colors")
    widths = read_rows(reviewed[0], "/classification/**", "SeriesLines:widths")
    for number, category in enumerate(CATEGORIES):
        for path in (f"/classification/{category}", f"/classification/fused/{category}"):
            assert colors[path][-1] == [packed(entities.category_color(number))]
            assert widths[path][-1] == [4.0 if category == "coffee_mug" else 1.5]


@pytest.mark.parametrize("number", range(10))
@pytest.mark.parametrize("background", [(255, 255, 255), (13, 13, 13)])
def test_categories_are_legible_on_light_and_dark(number, background):
    assert contrast(entities.category_color(number), background) >= 3  # WCAG 2.1, 1.4.11


def test_ten_categories_have_ten_colours():
    colors = np.array([entities.category_color(number) for number in range(10)])
    apart = np.linalg.norm(colors[:, None] - colors[None], axis=2)
    assert apart[np.triu_indices(10, 1)].min() > 45


def test_summary_says_what_it_is_and_whether_that_is_right(reviewed):
    words = read_rows(reviewed[0], "/summary", "TextDocument:text")["/summary"][-1][0]
    assert "**It is a bowl (48%, fused over 4 views); the recording says coffee_mug: wrong.**" in words
    assert "Alone, views 3 (bowl 80%), 1 (bowl 62%) say otherwise." in words  # worst first
    assert "Alone, view 2 would be unknown." in words


@pytest.mark.parametrize(
    ("truth", "known", "words"),
    [
        ("bowl", True, "It is a bowl (48%, fused over 4 views); the recording says bowl: right."),
        ("orange", True, "which the model does not know: wrong."),
        ("orange", False, "It is unknown: likeliest bowl 48%, fused over 4 views; the recording says orange, which"),
        ("orange", False, "which the model does not know: right."),
        ("bowl", False, "the recording says bowl: not recognised, but the likeliest."),
        ("cap", False, "the recording says cap: wrong."),
        (None, True, "It is a bowl (48%, fused over 4 views)."),
        ("", False, "It is unknown: likeliest bowl 48%, fused over 4 views."),
    ],
)
def test_the_answer_is_judged_by_the_true_category(truth, known, words):
    assert words in conclude(classify(known=known), truth)


def test_one_view_is_not_fused():
    assert conclude(classify(VIEWS[:1])) == "It is a coffee mug (84%, by one view)."


def test_without_a_true_category_views_are_judged_by_the_fused_one():
    _, session = make_classified(category=None)
    assert "Alone, view 0 (coffee_mug 84%) says otherwise. Alone, view 2 would be unknown." in describe_classification(
        session
    )


def test_views_of_an_object_that_the_model_has_not_say_otherwise_when_they_know_it():
    _, session = make_classified("orange", classify(known=False))
    words = describe_classification(session)
    assert "views 0 (coffee_mug 84%), 3 (bowl 80%), 1 (bowl 62%) say otherwise" in words  # the highest score first
    assert "would be unknown" not in words
    assert {view for view, _, _ in list_dissent(session)} == {0, 1, 3}


def test_views_that_say_otherwise_are_lines_of_the_log(reviewed):
    lines = read_all(reviewed[0], "/log", "TextLog:text")
    assert "view 1 (scan01), classification: alone it shows bowl 62%, not coffee_mug, as the recording says" in lines
    findings = {view: (level, text) for view, level, text in list_dissent(reviewed[1][1])}
    assert list(findings) == [1, 2, 3]
    assert findings[1][0] == rr.TextLogLevel.WARN
    assert findings[2][0] == rr.TextLogLevel.INFO
    assert "alone it shows unknown (bowl 41%), not coffee_mug" in findings[2][1]
    assert "It is a bowl (48%, fused over 4 views); the recording says coffee_mug: wrong." in lines


def test_table_has_a_column_of_what_views_show(reviewed):
    table = read_rows(reviewed[0], "/table", "TextDocument:text")["/table"][-1][0].splitlines()
    assert table[2].startswith("| view | status | shows |")
    assert table[4].startswith("| 0 | ok | coffee_mug 84% |")
    assert describe_view(classify().views[2]) == "unknown (bowl 41%)"
    assert "| unknown (bowl 41%) |" in table[6]


def test_categories_that_stay_unlikely_are_not_looked_at():
    assert shown_categories(classify(), None) == ["bowl", "cap", "coffee_mug"]
    assert shown_categories(classify(), "pliers") == list(CATEGORIES)


def test_nothing_of_it_appears_without_a_classification(tmp_path):
    views, session = make_results()
    with SessionReview(tmp_path / "review.rrd", make_info(5), METHODS) as review:
        for result in views:
            review.add_view(result)
        review.add_session(session)
    paths = {chunk.entity_path for chunk in RrdReader(tmp_path / "review.rrd").stream()}
    assert not [path for path in paths if path.startswith("/classification")]
    words = read_all(tmp_path / "review.rrd", "/**", "TextDocument:text")
    assert not [text for text in words if "It is" in text or "shows" in text]


@pytest.mark.usefixtures("renderer")
@pytest.mark.parametrize("finished", [True, False])
def test_viewer_draws_everything(finished, tmp_path):
    path = tmp_path / "review.rrd"
    views, session = make_classified()
    info = replace(make_info(len(views)), category="coffee_mug")
    with SessionReview(path, info, METHODS, true_poses(len(views))) as review:
        for result in views:
            review.add_view(result)
        if finished:
            review.add_session(session)
    with viewer.open_viewer(path) as client:
        names = {view.name for view in client.get_state().views}
        assert viewer.find_reports(client) == []
    assert set(entities.CLASSES.values()) <= names


def test_a_chunk_of_the_log_is_of_one_view(reviewed):
    """The viewer gives lines the levels of others where chunks of several views overlap in time."""
    chunks = [chunk.to_record_batch() for chunk in RrdReader(reviewed[0]).stream().filter(content="/log")]
    assert [len(set(chunk.column("view").to_pylist())) for chunk in chunks] == [1] * len(chunks)
