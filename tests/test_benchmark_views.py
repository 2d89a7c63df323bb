"""The benchmark of lost views: which sessions it makes, and what it counts."""

from collections import Counter

import numpy as np
import pytest

from orbitscan.processing.results.status import Method, Status
from tests.benchmarks import views
from tests.benchmarks.views import Cost, Lost


@pytest.mark.parametrize("kind", views.KINDS)
def test_a_session_knows_which_views_show_the_object(kind):
    session, own = views.make("robot", kind)
    count = len(session.names)
    assert own == set(session.truth())
    assert len(own) == (count - 1 if kind.startswith("foreign") else count)
    steps = [np.linalg.norm(session.truth()[i][:3, 3] - session.truth()[i - 1][:3, 3]) for i in own if i - 1 in own]
    assert (max(steps) > 3 * np.median(steps)) == (kind == "parts")


def test_failed_views_are_counted_by_method(capsys):
    one = {Method.PAIRWISE: 2, Method.REFINED: 0}
    none = dict.fromkeys(views.METHODS, 0)
    whole = dict.fromkeys(views.METHODS, (18,))
    views.report_lost([Lost("robot", "even", 18, one, none, whole), Lost("statue", "parts", 9, none, none, whole)])
    printed = capsys.readouterr().out
    assert "pairwise: right views called failed 2 of 27" in printed
    assert "at most 5%: NOT MET" in printed
    assert "at most 2%: met" in printed
    assert "robot, even: pairwise 2 failed" in printed


def test_a_view_costs_a_share_of_its_session(capsys):
    statuses = {method: Counter({Status.OK: 50}) for method in views.METHODS}
    views.report_many([Cost("bin", 50, 30.0, 20.0, 0.5, statuses, 0)])
    row = capsys.readouterr().out.splitlines()[1]
    assert row.split() == ["bin,", "50", "views", "30", "20", "50", "1.00", "0.50", "ok", "50", "0"]
