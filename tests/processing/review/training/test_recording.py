"""The review of a training: what is read back equals the epochs, a killed one is readable, the viewer draws it."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from orbitscan.processing.classification.evaluation import EpochRecord
from orbitscan.processing.classification.training import TrainingSettings
from orbitscan.processing.review import entities
from orbitscan.processing.review.matrix import draw_matrix
from orbitscan.processing.review.training.recording import TrainingReview, describe_epoch, tabulate_settings
from orbitscan.recorder.exceptions import UnwritableOutput
from tests import viewer

ROOT = Path(__file__).parents[4]
CATEGORIES = ("bowl", "cap", "coffee_mug")
RECORDS = [
    EpochRecord(1.1, 0.5, 1.2, 0.4, 1, ((4, 4, 2), (5, 5, 0), (0, 0, 10)), 400.0),
    EpochRecord(0.3, 0.9, 0.5, 0.8, 2, ((9, 1, 0), (0, 10, 0), (3, 0, 7)), 420.0),
]


@pytest.fixture(scope="module")
def reviewed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("training") / "model.rrd"
    write_review(path)
    return path


def write_review(path: Path) -> None:
    with TrainingReview(path, CATEGORIES, TrainingSettings(epochs=2)) as review:
        for record in RECORDS:
            review.add(record)


def read_rows(path: Path, content: str, column: str) -> dict[str, dict[int, list]]:
    """Entity -> epoch -> cell; a static cell is at -1."""
    rows: dict[str, dict[int, list]] = {}
    for chunk in RrdReader(path).stream().filter(content=content):
        batch = chunk.to_record_batch()
        if column in batch.schema.names:
            times = batch.column("epoch").to_pylist() if "epoch" in batch.schema.names else [-1] * batch.num_rows
            rows.setdefault(chunk.entity_path, {}).update(zip(times, batch.column(column).to_pylist(), strict=True))
    return rows


def test_curves_read_back_equal_the_epochs(reviewed):
    curves = read_rows(reviewed, "/**", "Scalars:scalars")
    fields = {
        "/loss/training": "train_loss",
        "/loss/validation": "validation_loss",
        "/accuracy/training": "train_accuracy",
        "/accuracy/validation": "validation_accuracy",
        "/overfitting": "overfitting",
        "/views_per_second": "views_per_second",
    }
    assert curves == {path: {r.epoch: [getattr(r, field)] for r in RECORDS} for path, field in fields.items()}
    assert set(read_rows(reviewed, "/**", "SeriesLines:colors")) == set(fields)


def test_a_matrix_is_drawn_for_each_epoch_with_its_numbers_and_names(reviewed):
    numbers = read_rows(reviewed, "/confusion/**", "Points2D:labels")["/confusion/numbers"]
    assert numbers == {1: ["4", "4", "2", "5", "5", "10"], 2: ["9", "1", "10", "3", "7"]}
    names = read_rows(reviewed, "/confusion/**", "Points2D:labels")["/confusion/names"][2]
    assert names == ["bowl", "cap", "coffee mug", "bowl", "cap", "coffee\nmug"]
    assert set(read_rows(reviewed, "/confusion/**", "Image:buffer")["/confusion/cells"]) == {1, 2}


def test_cells_are_green_where_right_and_red_where_wrong():
    drawing = draw_matrix(np.array([[8, 0], [2, 8], [0, 3]]), ("cap", "bowl", "orange"), ("cap", "bowl"))
    image = pixels(drawing["cells"])
    assert image.shape == (3 * 24, 2 * 24, 3)
    middle = image[12::24, 12::24].astype(int)
    assert np.array_equal(middle[0, 0], entities.GOOD_COLOR)  # the whole row
    assert np.array_equal(middle[2, 1], entities.BAD_COLOR)
    assert np.array_equal(middle[0, 1], middle[2, 0])  # nothing there
    assert middle[1, 0, 0] > middle[1, 0, 1]
    assert middle[1, 1, 1] > middle[1, 1, 0]


def pixels(image: rr.Image) -> np.ndarray:
    shape = image.format.as_arrow_array()[0].as_py()
    values = image.buffer.as_arrow_array()[0].as_py()
    return np.array(values, np.uint8).reshape(shape["height"], shape["width"], 3)


def test_a_matrix_without_any_count_has_no_numbers(tmp_path):
    nothing = replace(RECORDS[0], confusion=((0, 0, 0),) * 3, validation_loss=math.nan, validation_accuracy=math.nan)
    with TrainingReview(tmp_path / "model.rrd", CATEGORIES, TrainingSettings()) as review:
        review.add(nothing)
    curves = read_rows(tmp_path / "model.rrd", "/**", "Scalars:scalars")
    assert set(curves) == {"/loss/training", "/accuracy/training", "/views_per_second"}


def test_an_epoch_in_words_names_what_is_confused_most():
    words = describe_epoch(RECORDS[1], CATEGORIES, 12)
    assert "## Epoch 2 of 12" in words
    assert "**80.00%** are right, of the training views 90.00%" in words
    lines = [line for line in words.splitlines() if line.startswith("- ")]
    assert lines == ["- coffee_mug taken for bowl: 30.0% of its views", "- bowl taken for cap: 10.0% of its views"]


def test_all_settings_are_told():
    table = tabulate_settings(TrainingSettings(epochs=7))
    assert "| epochs | 7 |" in table
    assert "| voxels.values | density |" in table
    assert "| structure | (default) |" in table


def test_it_is_there_when_complete_and_can_be_read_before(tmp_path):
    path = tmp_path / "models" / "model.rrd"
    with TrainingReview(path, CATEGORIES, TrainingSettings()) as review:
        review.add(RECORDS[0])
        assert not path.exists()
        assert (path.parent / "model.part.rrd").stat().st_size > 0
    assert [p.name for p in path.parent.iterdir()] == ["model.rrd"]
    assert subprocess.run([viewer.RERUN, "rrd", "verify", path], capture_output=True).returncode == 0


@pytest.mark.parametrize("epochs", [0, 1])
def test_a_failed_training_leaves_the_epochs_it_reached(epochs, tmp_path):
    review = TrainingReview(tmp_path / "model.rrd", CATEGORIES, TrainingSettings())
    for record in RECORDS[:epochs]:
        review.add(record)
    review.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert [p.name for p in tmp_path.iterdir()] == ["model.part.rrd"][:epochs]


def test_a_killed_training_is_readable_up_to_its_last_epoch(tmp_path):
    script = f"""
import os
from pathlib import Path
from tests.processing.review.training.test_recording import CATEGORIES, RECORDS, TrainingReview, TrainingSettings
review = TrainingReview(Path({str(tmp_path / "model.rrd")!r}), CATEGORIES, TrainingSettings())
review.add(RECORDS[0])
os._exit(9)
"""
    assert subprocess.run([sys.executable, "-c", script], cwd=ROOT).returncode == 9
    with pytest.warns(match="footer"):
        curves = read_rows(tmp_path / "model.part.rrd", "/**", "Scalars:scalars")
    assert curves["/loss/validation"] == {1: [1.2]}


def test_a_place_that_cannot_be_written_is_told_in_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UnwritableOutput, match="cannot be written"):
        TrainingReview(tmp_path / "file" / "model.rrd", CATEGORIES, TrainingSettings())


@pytest.mark.usefixtures("renderer")
def test_viewer_draws_everything(reviewed):
    with viewer.open_viewer(reviewed) as client:
        names = {view.name for view in client.get_state().views}
        assert viewer.find_reports(client) == []
    assert {"Loss: cross-entropy [nats]", "Accuracy [share of the views]", "Summary"} <= names
