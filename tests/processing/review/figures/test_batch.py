"""The figure of a batch: a point for each session, nothing without truth."""

import pytest

from orbitscan.processing.review.figures import batch
from tests.processing.review.batch.test_recording import ROWS, row


def test_a_batch_has_a_point_for_each_session_and_the_median():
    figure = batch.draw_batch([row("cup", 1e-3, failed=1), row("bowl", 1e-3), row("cap", 5.0, failed=1)])
    axes = figure.axes[0]
    points = {line.get_marker(): list(line.get_ydata()) for line in axes.lines}
    assert points["o"] == pytest.approx([0.25, 0.25, 1250])  # millimetres
    assert axes.get_yscale() == "log"
    labels = [label.get_text() for label in axes.get_xticklabels()]
    assert labels == ["icp\n2 of 3", "ransac_icp\n2 of 3", "pairwise\n2 of 3", "refined\n2 of 3"]
    medians = [float(c.get_segments()[0][0, 1]) for c in axes.collections]
    assert medians[3] == pytest.approx(0.25)


def test_a_batch_without_truth_has_no_figure(tmp_path):
    assert batch.write_batch_figure(tmp_path, [row("cup")]) == []
    assert not list(tmp_path.iterdir())


def test_a_batch_figure_is_written(tmp_path):
    assert [p.name for p in batch.write_batch_figure(tmp_path, ROWS)] == ["errors.png", "errors.svg"]
