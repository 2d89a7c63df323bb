"""Sentences fall into claim, verdict and evidence; rows into columns and curves; studies into a recording."""

import io
import subprocess

import numpy as np
import pytest
from matplotlib.figure import Figure
from rerun.chunk import RrdReader

from orbitscan.processing.reproduction.claims import compare
from orbitscan.processing.reproduction.index.claims_grid import draw_claims
from orbitscan.processing.reproduction.index.columns import lay_out_columns, name_column, write_value
from orbitscan.processing.reproduction.index.layout import SHARED_TIMELINE
from orbitscan.processing.reproduction.index.recording import (
    _color_lines,
    list_claims,
    tabulate_rows,
    write_reproduction,
)
from orbitscan.processing.reproduction.index.study import StudyReview, find_curves, find_timeline
from orbitscan.processing.reproduction.verdicts import Statement, conclude, count_verdicts
from orbitscan.processing.review import entities
from orbitscan.recorder.exceptions import UnwritableOutput
from tests import viewer

# --- verdicts


@pytest.mark.parametrize(
    ("larger", "verdict"),
    [([3, 4, 5], "holds"), ([-3, -4, -5], "does not hold"), ([1, -1, 0], "cannot be told"), ([5], "cannot be told")],
)
def test_a_claim_as_written_is_read_back(larger, verdict):
    written = str(compare("A: b is more accurate than C(3,2)", larger, [0] * len(larger), "points"))
    found = Statement.read(written)
    assert (found.claim, found.verdict) == ("A: b is more accurate than C(3,2)", verdict)
    assert found.evidence.startswith("difference ")
    assert not found.evidence.endswith((")", "."))


@pytest.mark.parametrize("sentence", ["Most accurate: PCA, 92 %.", "It holds.", "x: holdsome", ": holds"])
def test_a_sentence_without_a_verdict_is_all_claim(sentence):
    assert Statement.read(sentence) == Statement(sentence)


@pytest.mark.parametrize(
    ("sentence", "evidence"),
    [
        ("A: holds.", ""),
        ("A: holds", ""),
        ("A: holds; 2 mm against 3 mm.", "2 mm against 3 mm."),
        ("A: does not hold (1 of 2).", "1 of 2"),
        ("A: cannot be told (one run) and (no truth).", "(one run) and (no truth)."),
    ],
)
def test_evidence_is_what_follows_the_verdict(sentence, evidence):
    assert Statement.read(sentence).evidence == evidence


def test_verdicts_are_counted_and_told():
    counts = count_verdicts(["A: holds.", "B: holds (1).", "C: does not hold.", "Nothing is claimed."])
    assert counts == {"holds": 2, "does not hold": 1, "cannot be told": 0}
    assert conclude(counts) == "Of 3 claims tested, 2 hold, 1 does not hold, and 0 cannot be told."
    assert "No claim" in conclude(count_verdicts([]))


# --- columns


def test_the_thesis_stands_beside_ours_with_its_own_digits():
    rows = [
        {"loss": 2.03828, "thesis_loss": 0.2866, "time_s": 3.0, "note": None, "thesis_accuracy_percent": 92.2},
        {"loss": 0.5, "thesis_loss": 0.388, "time_s": 20.0, "note": "a", "thesis_accuracy_percent": None},
    ]
    rows = [{"thesis_loss": row["thesis_loss"], **row} for row in rows]  # the thesis's first
    columns = {column.name: column for column in lay_out_columns(rows)}
    assert list(columns) == ["loss", "thesis_loss", "time_s", "note", "thesis_accuracy_percent"]
    assert columns["loss"].cells == ("2.0383", "0.5000")
    assert columns["thesis_loss"].cells == ("0.2866", "0.3880")
    assert columns["time_s"].cells == ("3.00", "20.00")
    assert columns["thesis_accuracy_percent"].cells == ("92.2", "–")
    assert [name for name, column in columns.items() if not column.is_number] == ["note"]


def test_numbers_too_far_apart_have_digits_of_their_own():
    (column,) = lay_out_columns([{"seconds": value} for value in (0.0512, 6049.3, 0.0, float("nan"))])
    assert column.cells == ("0.0512", "6,049", "0", "–")


def test_values_and_names_in_words():
    assert [write_value(value) for value in (True, False, 12345, -3, "bin", None)] == [
        "yes",
        "no",
        "12,345",
        "−3",
        "bin",
        "–",
    ]
    assert write_value(-0.5, 2) == "−0.50"
    names = ("thesis_accuracy_percent", "translation_error_m", "seconds", "s")
    assert [name_column(name) for name in names] == [
        "accuracy [%], thesis",
        "translation error [m]",
        "seconds",
        "s",
    ]


# --- curves

FRAMES = [
    {"object": thing, "method": method, "view": view, "status": status, "error_m": error, "points": 5}
    for thing in ("bin", "robot")
    for method in ("icp", "refined")
    for view, status, error in ((14, "low_overlap", 0.2), (0, "ok", 0.1), (28, "ok", None))
]
STEPS = [{"start": start, "step": step, "loss": 1 / step, "thesis_loss": 0.3} for start in "ab" for step in (1, 2)]


def test_each_object_has_a_curve_for_each_method():
    found = find_curves(FRAMES)
    assert [(curve.plot, curve.line) for curve in found] == [
        (thing, method) for thing in ("bin", "robot") for method in ("icp", "refined")
    ]
    assert {(curve.quantity, curve.timeline, curve.times, curve.values) for curve in found} == {
        ("error_m", "view", (0, 14), (0.1, 0.2))
    }


@pytest.mark.parametrize("rows", [[], [{"start": "a", "loss": 0.5}], [{"figure": "3.4", "view": 40, "radius_mm": 5.0}]])
def test_rows_along_which_nothing_goes_on_have_no_curves(rows):
    assert find_timeline(rows) is None
    assert find_curves(rows) == []


# --- the recording


def test_a_control_beside_the_methods_has_no_method_s_colour():
    colors = _color_lines(["icp", "identity", "refined"])
    assert colors["icp"] == entities.METHOD_COLORS["icp"]
    assert colors["identity"] not in entities.METHOD_COLORS.values()
    assert len(set(_color_lines(["PCA", "ZCA", "DCAE"]).values())) == 3


def draw_png(width: float, height: float) -> bytes:
    content = io.BytesIO()
    Figure(figsize=(width, height), dpi=20).savefig(content)
    return content.getvalue()


def make_groups() -> dict[str, list[StudyReview]]:
    """A study of each kind."""
    claims = ["PCA is better: holds (1 point).", "ZCA | b is better: does not hold.", "DCAE: cannot be told (one run)."]
    training = {"name": "figure-5.2", "title": "Training", "rows": STEPS, "said": ["Best: a.", *claims]}
    errors = {
        "name": "figure-5.8",
        "title": "Errors",
        "rows": [{"object": "bin", "median_mm": 0.5}],
        "said": [f"At {i}: holds." for i in range(12)],
    }
    models = {"name": "figure-5.9", "title": "Models", "rows": [{"object": "bin | lid", "points": 9}], "said": []}
    points = np.random.default_rng(0).normal(size=(45_000, 3)).astype(np.float32)
    return {
        "Classification": [StudyReview(training, {"figure-5.2": draw_png(9, 3)})],
        "Registration": [
            StudyReview(errors, frames=FRAMES),
            StudyReview(
                models,
                {"figure-5.9": draw_png(3, 4)},
                models={"bin": {"icp": (points, None), "refined": (points[:9], None)}},
            ),
        ],
        "Overlap": [],
    }


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("reproduction") / "reproduction.rrd"
    write_reproduction(path, make_groups(), "- Runs: 3")
    return path


def read(path, content: str) -> dict[str, list]:
    """Entity -> its record batches."""
    found: dict[str, list] = {}
    for chunk in RrdReader(path).stream().filter(content=content):
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def test_curves_are_on_their_own_timeline_and_on_the_shared_one(recording):
    batches = read(recording, "/studies/**")
    for part, name, times in (("loss/a", "step", [1, 2]), ("bin/error_m/icp", "view", [0, 14])):
        (found,) = (
            batch
            for path, all_batches in batches.items()
            for batch in all_batches
            if path.endswith(part) and "Scalars:scalars" in batch.schema.names
        )
        assert found.column(name).to_pylist() == found.column(SHARED_TIMELINE).to_pylist() == times


def test_models_are_thinned(recording):
    counts = [
        len(batch.column("Points3D:positions").to_pylist()[0])
        for batches in read(recording, "/studies/**").values()
        for batch in batches
        if "Points3D:positions" in batch.schema.names
    ]
    assert sorted(counts) == [9, 15_000]


def test_the_summary_sorts_the_claims_by_verdict(recording):
    assert len(read(recording, "/summary/**")) == 1 + 3 + 3  # what was run, the lists, the grid
    studies = [study for group in make_groups().values() for study in group]
    assert list_claims(studies, "does not hold") == "**figure-5.2**\n\n- ZCA | b is better\n"
    assert list_claims(studies[:1], "holds").count("- ") == 1
    assert list_claims(studies[2:], "holds") == "None."


def test_a_study_with_many_claims_goes_on_in_the_next_row():
    grid = draw_claims({"a": ["holds"] * 12, "b": ["does not hold"]})
    labels = {name: drawing.labels.as_arrow_array().to_pylist() for name, drawing in grid.items() if name != "cells"}
    assert labels["marks"] == ["yes"] * 12 + ["no"]
    places = grid["studies"].positions.as_arrow_array().to_pylist()
    assert places[1][1] - places[0][1] == 2 * (draw_height(grid) / 3)
    assert draw_claims({})["cells"] is not None


def draw_height(grid) -> int:
    return grid["cells"].format.as_arrow_array().to_pylist()[0]["height"]


def test_numbers_are_a_table_of_which_a_long_one_shows_the_first():
    (short, long) = (
        tabulate_rows({"name": "table-5.1", "rows": [{"object": "bin | lid", "points": i} for i in range(n)]})
        for n in (2, 50)
    )
    assert short.splitlines() == ["| object | points |", "| --- | --- |", "| bin / lid | 0 |", "| bin / lid | 1 |"]
    assert long.endswith("All 50 rows of 2 columns are in table-5.1.csv.")
    assert len(long.splitlines()) < 50
    assert tabulate_rows({"name": "gallery", "rows": []}) == "No numbers."


def test_the_same_studies_give_the_same_recording(recording, tmp_path):
    write_reproduction(tmp_path / "again.rrd", make_groups(), "- Runs: 3")
    assert subprocess.run([viewer.RERUN, "rrd", "verify", recording], capture_output=True).returncode == 0
    assert subprocess.run([viewer.RERUN, "rrd", "compare", recording, tmp_path / "again.rrd"]).returncode == 0
    assert len(RrdReader(recording).blueprints()) == 1


def test_a_place_that_cannot_be_written_is_left_as_it_is(tmp_path):
    (tmp_path / "taken").mkdir()
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        write_reproduction(tmp_path / "taken", make_groups(), "")
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


@pytest.mark.usefixtures("renderer")
def test_viewer_draws_everything(recording):
    with viewer.open_viewer(recording) as client:
        assert viewer.find_reports(client) == []
