"""A batch's confusion: counted from results, with a row and a column for what is unknown; CSV and drawing."""

import csv

import numpy as np
import pytest
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from orbitscan.processing.results.classification import SessionClassification, ViewClassification
from orbitscan.processing.results.confusion import Confusion, count_confusion, tabulate, write_csv
from orbitscan.processing.results.folder import Results
from orbitscan.processing.review.batch.confusion import count_right, describe_confusion, log_confusion, view_confusion
from orbitscan.processing.review.stream import whole_recording
from orbitscan.recorder.exceptions import UnwritableOutput
from tests.processing.results.made import make_results

CATEGORIES = ("bowl", "cap", "coffee_mug")


def session(
    name: str, category: str | None, found: str | None, views: list[str | None], classified: bool = True
) -> Results:
    """The results of what counts; None is unknown."""
    alone = tuple(
        ViewClassification(i, view, view or "bowl", view is not None, 0.0, {"bowl": 1.0})
        for i, view in enumerate(views)
    )
    answer = SessionClassification("", CATEGORIES, found, found or "bowl", found is not None, 0.7, (), (), alone)
    return make_results(name, category, classification=answer if classified else None)


@pytest.fixture
def confusion() -> Confusion:
    sessions = [
        session("mug_1", "coffee_mug", "coffee_mug", ["coffee_mug", "bowl", None]),
        session("bowl_1", "bowl", "cap", ["cap", "cap", "bowl"]),
        session("bowl_2", "bowl", None, [None]),
        session("orange_1", "orange", "bowl", ["bowl", None]),
        session("banana_1", "banana", None, [None, None]),
        session("unlabelled", None, "cap", ["cap"]),
        session("unclassified", "cap", None, [], classified=False),
    ]
    return count_confusion(sessions)


def test_counts_of_recordings_and_of_views(confusion):
    assert confusion.names == ("bowl", "cap", "coffee_mug", "unknown")
    assert confusion.sessions.tolist() == [[0, 1, 0, 1], [0, 0, 0, 0], [0, 0, 1, 0], [1, 0, 0, 1]]
    assert confusion.views.tolist() == [[1, 2, 0, 1], [0, 0, 0, 0], [1, 0, 1, 1], [1, 0, 0, 3]]
    assert [answer.session for answer in confusion.answers if answer.right] == ["banana_1", "mug_1"]


def test_one_labelled_recording_is_no_batch():
    one = session("a", "bowl", "bowl", ["bowl"])
    other = session("b", None, "bowl", ["bowl"])
    assert count_confusion([one, other]) is None
    assert count_confusion([]) is None


def test_the_order_of_the_sessions_does_not_count():
    sessions = [session(name, "bowl", "bowl", ["bowl"]) for name in ("b", "a")]
    assert [a.session for a in count_confusion(sessions).answers] == ["a", "b"]


def test_csv_reads_back_equal(confusion, tmp_path):
    write_csv(tmp_path / "confusion.csv", confusion)
    with (tmp_path / "confusion.csv").open() as stream:
        header, *rows = csv.reader(stream)
    assert header == ["counted", "true", *confusion.names]
    assert [row[:2] for row in rows] == [[c, n] for c in ("recordings", "views") for n in confusion.names]
    counts = np.array([[int(cell) for cell in row[2:]] for row in rows])
    assert np.array_equal(counts, np.concatenate([confusion.sessions, confusion.views]))


def test_words_name_the_recordings_that_are_wrong(confusion):
    assert count_right(confusion) == "Right: 2 of 5 recordings (40.0%), 5 of 11 views alone (45.5%)."
    words = "\n".join(describe_confusion(confusion))
    assert "| bowl_1 | bowl | cap | cap 70% |" in words
    assert "| bowl_2 | bowl | unknown | bowl 70% |" in words
    assert "| orange_1 | orange | bowl | bowl 70% |" in words
    assert "banana_1" not in words


def test_the_printed_table_has_a_row_for_each_category_that_occurs(confusion):
    assert tabulate(confusion) == [
        ("bowl", "0 of 2", "25.0%", "cap 1, unknown 1"),
        ("coffee_mug", "1 of 1", "33.3%", ""),
        ("unknown", "1 of 2", "75.0%", "bowl 1"),
    ]


def test_recording_has_the_numbers_and_names(confusion, tmp_path):
    path = tmp_path / "confusion.rrd"
    with whole_recording(path, "test", rrb.Blueprint(view_confusion(len(confusion.names)))) as stream:
        log_confusion(stream, confusion)
    labels = {}
    for chunk in RrdReader(path).stream().filter(content="/confusion/**"):
        batch = chunk.to_record_batch()
        if "Points2D:labels" in batch.schema.names:
            labels[chunk.entity_path] = batch.column("Points2D:labels").to_pylist()[0]
    assert labels["/confusion/sessions/numbers"] == ["1"] * 5
    assert labels["/confusion/views/numbers"] == ["1", "2", "1", "1", "1", "1", "1", "3"]
    names = ["bowl", "cap", "coffee mug", "unknown", "bowl", "cap", "coffee\nmug", "unknown"]
    assert labels["/confusion/sessions/names"] == labels["/confusion/views/names"] == names


def test_a_place_that_cannot_be_written_is_left_as_it_is(confusion, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        write_csv(tmp_path / "file" / "confusion", confusion)
    (tmp_path / "taken").mkdir()
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        write_csv(tmp_path / "taken", confusion)
    assert not [path.name for path in tmp_path.iterdir() if path.name.endswith(".part")]
