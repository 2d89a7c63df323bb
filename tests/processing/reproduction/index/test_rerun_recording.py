"""Rows fall into columns and curves, studies into a recording."""

import io
import subprocess

import numpy as np
import pytest
from matplotlib.figure import Figure
from rerun.chunk import RrdReader

from orbitscan.processing.reproduction.claims import Claim, Verdict
from orbitscan.processing.reproduction.index.claims_grid import draw_claims
from orbitscan.processing.reproduction.index.columns import lay_out_columns, name_column, write_value
from orbitscan.processing.reproduction.index.layout import SHARED_TIMELINE
from orbitscan.processing.reproduction.index.rerun_recording import (
    _color_lines,
    list_claims,
    tabulate_rows,
    write_reproduction,
)
from orbitscan.processing.reproduction.index.study import StudyReview, find_curves, find_timeline
from orbitscan.processing.reproduction.report import FORMAT_VERSION, SavedReport
from orbitscan.processing.review import entities
from orbitscan.recorder.exceptions import UnwritableOutput
from tests import viewer

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
    assert [name_column(name) for name in names] == ["accuracy [%], thesis", "translation error [m]", "seconds", "s"]


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


def save(name, rows, said=(), claims=()) -> SavedReport:
    """A report as it is read."""
    machine = {"cores": 2}
    return SavedReport(
        FORMAT_VERSION, name, name.title(), f"orbitscan reproduce {name}", list(said), list(claims), rows, [],
        "virtual corpus", 1, [0], 1.0, "cpu", "float32", {}, {"orbitscan": "1"}, machine,
    )  # fmt: skip


def make_groups() -> dict[str, list[StudyReview]]:
    """A study of each kind."""
    claims = [
        Claim("PCA is better", Verdict.HOLDS, 1.0, (0.5, 2.0), 10, "points"),
        Claim("ZCA | b is better", Verdict.FAILS),
        Claim("DCAE is better", Verdict.OPEN, 1.0, None, 1, "points"),
    ]
    training = save("figure-5.2", STEPS, ["Best: a."], claims)
    errors = save(
        "figure-5.8",
        [{"object": "bin", "median_mm": 0.5}],
        claims=[Claim(f"It holds at {i}", Verdict.HOLDS) for i in range(12)],
    )
    models = save("figure-5.9", [{"object": "bin | lid", "points": 9}])
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
    assert list_claims(studies, Verdict.FAILS) == "**figure-5.2**\n\n- ZCA | b is better\n"
    assert list_claims(studies[:1], Verdict.HOLDS).count("- ") == 1
    assert list_claims(studies[2:], Verdict.HOLDS) == "None."


def test_a_study_with_many_claims_goes_on_in_the_next_row():
    grid = draw_claims({"a": [Claim("a", Verdict.HOLDS)] * 12, "b": [Claim("b", Verdict.FAILS)]})
    labels = {name: drawing.labels.as_arrow_array().to_pylist() for name, drawing in grid.items() if name != "cells"}
    assert labels["marks"] == ["yes"] * 12 + ["no"]
    places = grid["studies"].positions.as_arrow_array().to_pylist()
    assert places[1][1] - places[0][1] == 2 * (draw_height(grid) / 3)
    assert draw_claims({})["cells"] is not None


def draw_height(grid) -> int:
    return grid["cells"].format.as_arrow_array().to_pylist()[0]["height"]


def test_numbers_are_a_table_of_which_a_long_one_shows_the_first():
    (short, long) = (
        tabulate_rows(save("table-5.1", [{"object": "bin | lid", "points": i} for i in range(n)])) for n in (2, 50)
    )
    assert short.splitlines() == ["| object | points |", "| --- | --- |", "| bin / lid | 0 |", "| bin / lid | 1 |"]
    assert long.endswith("All 50 rows of 2 columns are in table-5.1.csv.")
    assert len(long.splitlines()) < 50
    assert tabulate_rows(save("gallery", [])) == "No numbers."


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
