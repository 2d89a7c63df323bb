"""What a batch prints beneath its errors: what ok is worth, what is open, what the user's step settled."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbitscan.processing.batch.recording import Outcome
from orbitscan.processing.cli import report
from orbitscan.processing.results.batch_table import Row
from orbitscan.processing.results.estimates import MethodResult, Symmetry, ViewEstimate
from orbitscan.processing.results.status import Method, Status
from tests.processing.results.made import make_folder
from tests.processing.review.made_results import make_pair

HEXAGON = Symmetry(np.array([0.0, -0.87, -0.5]), np.zeros(3), 6)


@pytest.fixture
def show(monkeypatch, capsys):
    """Prints a session's results by icp and refined, and gives the lines back."""

    def print_report(status, of_object=(), **of_pair):
        views = ViewEstimate(0, Status.OK, np.eye(4)), ViewEstimate(1, status, np.eye(4))
        pair = replace(make_pair(1, 0, status, True, 2000), **of_pair)
        by_icp = MethodResult.of([replace(view, status=Status.OK) for view in views], [], 0)
        refined = MethodResult.of(views, [pair], 0, symmetries=of_object)
        folder = make_folder("blob", {}, views=2, reconstruction={Method.ICP: by_icp, Method.REFINED: refined})
        monkeypatch.setattr(report, "read_row", lambda path: Row(path.name, "done", None, folder))
        report.report_batch([Outcome(Path("blob.mcap"), Path("blob"), "done")], Path())
        return capsys.readouterr().out.splitlines()

    return print_report


def test_a_count_says_what_it_counts_and_what_ok_is_worth(show):
    lines = show(Status.DIVERGED)
    assert any(line.split()[:3] == ["blob", "icp", "0"] and "†" in line for line in lines)
    assert any(line.split()[:2] == ["refined", "1"] and "†" not in line for line in lines)
    assert "† unchecked against other poses: what these methods call ok may be far off" in lines
    assert "not ok" in "\n".join(lines)
    assert "failed" not in "\n".join(lines)


def test_a_symmetry_has_a_line(show):
    lines = show(Status.AMBIGUOUS, (HEXAGON,), symmetries=(HEXAGON,))
    assert "blob: 6-fold about (0.00, -0.87, -0.50): turned by any multiple of 60° it looks the same" in lines
    assert any("blob: 1 views are ambiguous: the object looks the same from several sides" in line for line in lines)


def test_a_view_that_is_known_too_badly_is_not_said_to_look_the_same(show):
    text = "\n".join(show(Status.AMBIGUOUS, rotation_bound_deg=7.0, center_bound_m=0.01))
    assert "1 views are ambiguous: nothing competes with their poses" in text
    assert "looks the same" not in text


def test_what_the_step_or_colours_settled_has_a_line(show):
    assert "blob: view 1 by the user's step" in show(Status.OK, start="step")
    assert "blob: view 1 by colours" in show(Status.OK, start="color")


def test_a_symmetry_that_colours_tell_leaves_nothing_open(show):
    lines = show(Status.AMBIGUOUS, (replace(HEXAGON, told_by_color=True),), rotation_bound_deg=7.0, center_bound_m=0.01)
    assert any(
        line.endswith("turned by any multiple of 60° it has the same shape, but for its colours") for line in lines
    )
    assert any("1 views are ambiguous: nothing competes with their poses" in line for line in lines)
