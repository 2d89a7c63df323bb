"""Figures show what they are given: places, notches, hatches, numbers."""

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from orbitscan.processing.reproduction import charts


@pytest.fixture
def axes():
    _, ((axes,),) = charts.new_figure()
    return axes


@pytest.mark.parametrize("sideways", [False, True])
def test_each_run_is_a_point_of_its_sample(axes, sideways):
    charts.draw_boxes(axes, {"few": [1.0, 4.0], "many": np.arange(9.0)}, "loss [nats]", sideways)
    points = [line for line in axes.lines if line.get_marker() == "o"]
    values = [line.get_xdata() if sideways else line.get_ydata() for line in points]
    assert [list(v) for v in values] == [[1.0, 4.0], list(np.arange(9.0))]
    labels = axes.get_yticklabels() if sideways else axes.get_xticklabels()
    assert [label.get_text() for label in labels] == ["few", "many"]
    (median,) = (c for c in axes.collections if isinstance(c, LineCollection))  # of the few, without a box
    assert 2.5 in median.get_segments()[0]


def test_a_curve_is_the_mean_of_its_runs(axes):
    charts.draw_curves(axes, [1, 2, 3], {"a": np.array([[0, 1, 2], [2, 3, 4]]), "b": np.zeros((1, 3))}, "loss", "step")
    first, second = axes.lines
    assert list(first.get_ydata()) == [1, 2, 3]
    assert first.get_linestyle() != second.get_linestyle()
    assert len(axes.collections) == 1  # a band where there are several runs


def test_bars_stand_side_by_side_with_other_hatches(axes):
    charts.draw_bars(axes, ["x", "y"], {"a": [1, 2], "b": [3, np.nan]}, "seconds")
    first, second = axes.containers
    assert [bar.get_height() for bar in first] == [1, 2]
    assert first[0].get_x() + first[0].get_width() == pytest.approx(second[0].get_x())
    assert first[0].get_hatch() != second[0].get_hatch()


def test_a_matrix_is_in_per_cent_of_its_rows(axes):
    charts.draw_matrix(axes, np.array([[3, 1], [0, 0]]), ["a", "b"])
    assert [text.get_text() for text in axes.texts] == ["75", "25"]
    assert [text.get_text() for text in axes.get_xticklabels()] == ["a", "b"]
