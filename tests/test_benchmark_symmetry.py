"""The benchmark of symmetric objects: its solids are what they claim, its cases few enough, and a run can go on."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.results.estimates import Freedom, Symmetry
from orbitscan.processing.results.status import Status
from orbitscan.recorder.formats.mesh_file import read_mesh
from tests.benchmarks import symmetry, symmetry_scores
from tests.benchmarks.solids import SOLIDS
from tests.benchmarks.symmetry_scores import KINDS, RUN, Axis, Case, Found, MethodScore, PairScore, Score, ViewScore
from tests.benchmarks.symmetry_tables import OK_VIEWS, name_order, outside, report, write_json, wrong

SIX = Axis(6, "symmetry", 0.2)
EACH = pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS)


@EACH
def test_a_solid_is_closed_and_outside_out(solid):
    mesh = solid.mesh()
    edges = Counter((a, b) for t in mesh.triangles.tolist() for a, b in zip(t, (*t[1:], t[0]), strict=True))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    x, y = solid.outline.T
    area = (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2
    assert mesh.volume == pytest.approx(area * solid.height)
    assert area > 0


@EACH
def test_a_solid_has_its_order_and_no_higher_one(solid):
    vertices = solid.mesh().vertices
    assert matches(vertices, solid.mesh().turned("z", 360 / solid.order).vertices)
    for times in range(2, 40):
        assert not matches(vertices, solid.mesh().turned("z", 360 / (times * solid.order)).vertices)


def matches(a, b):
    """Whether two sets of points are the same."""
    apart = np.linalg.norm(a[:, None] - b[None], axis=2)
    return max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-9


def test_relief_is_measured_along_the_sides_too():
    assert SOLIDS["prism06"].relief == pytest.approx(0.05 * (1 - np.cos(np.pi / 6)))
    assert SOLIDS["gear09"].relief == pytest.approx(0.008, rel=0.05)
    assert SOLIDS["flute12"].relief == pytest.approx(0.008, rel=0.01)
    assert not Case("prism24", 30, 0.5).has_relief
    assert Case("prism12", 30, 1.0).has_relief
    assert not Case("prism12", 30, 2.0).has_relief


def test_a_written_solid_is_read_as_it_is(tmp_path):
    solid = SOLIDS["gear06"]
    np.testing.assert_allclose(read_mesh(solid.write(tmp_path)).vertices, solid.mesh().vertices, atol=1e-9)


def test_the_sessions_are_few_enough_and_distinct():
    whole, quick = symmetry.whole(), symmetry.slice_of_it()
    assert len(set(whole)) == len(whole) <= 600
    assert len(set(quick)) == len(quick) <= 24
    assert all(case.views <= 8 for case in quick)
    for cases in (whole, quick):
        assert {(case.kind, case.known) for case in cases} == {(k, b) for k in KINDS for b in (False, True)}
    assert {case.object for case in whole} >= set(SOLIDS)
    views = sum(case.views - 1 for case in whole if case.known and case.kind != "controls")
    assert views > OK_VIEWS


def score_of(case, degrees=0.1, axes=(SIX,), seconds=1.0):
    view = ViewScore(1, Status.OK, degrees, 0.001, 0.3, 0.001)
    pairs = (
        PairScore(1, 0, Status.AMBIGUOUS, 0.1, 0.001, 0.3, 0.001, (SIX,), 0),
        PairScore(2, 1, Status.AMBIGUOUS, 8.0, 0.001, 9.0, 0.001, (), 0),
        PairScore(3, 2, Status.AMBIGUOUS, 8.0, 0.001, 7.0, 0.001, (SIX,), 1),
    )
    return Score(case, 0.1, seconds, dict.fromkeys(RUN, MethodScore((view,), pairs, tuple(axes))))


def test_a_run_goes_on_where_it_was_cut(tmp_path):
    kept, cases, ran = tmp_path / "kept.jsonl", symmetry.slice_of_it()[:4], []

    def runner(case):
        ran.append(case)
        if case == cases[2] and len(ran) == 3:
            raise ValueError("cut")
        return score_of(case)

    first = symmetry.run_all(cases, kept, runner=runner)
    assert [score.case for score in first.scores] == [cases[0], cases[1], cases[3]]
    assert len(first.broken) == 1
    assert "ValueError: cut" in first.broken[0]
    kept.write_text(kept.read_text()[:-20])  # killed while it wrote the last one
    ran.clear()
    ran += [None]
    second = symmetry.run_all(cases, kept, runner=runner)
    assert ran[1:] == cases[2:]
    assert not second.broken
    assert second.scores == tuple(map(score_of, cases))
    ran.clear()
    assert symmetry.run_all(cases, kept, runner=runner) == second
    assert not ran


def test_the_report_counts_what_is_wrong(tmp_path, capsys):
    cases = Case("prism06", 60), Case("robot", 60), Case("gear09", 60)
    scores = score_of(cases[0]), score_of(cases[1], axes=()), score_of(cases[2], degrees=20.0)
    found = Found(scores, ("it broke",))
    assert [name_order(score) for score in (scores[0], scores[2])] == ["exact", "another"]
    assert not wrong(scores[0], "refined")
    assert len(wrong(scores[2], "refined")) == 1
    assert [pair.source for pair in outside(scores[0], "refined")] == [3]
    report(found, quick=True)
    shown = capsys.readouterr().out
    assert "wrong: refined, gear09 60 deg 1 mm, view 1: off 20 deg" in shown
    assert (
        "view 3 to 2: off 8 deg, centre 1 mm, bounds 7 deg, and 1 mm, declares order 6 about an axis 0.2 deg" in shown
    )
    assert "broken: it broke" in shown
    assert "1 of 2 = 50.00 % (1.26 to 98.74)" in shown
    path = tmp_path / "found.json"
    write_json(found, True, path)
    assert path.read_text().count('"gear09"') == 1
    report(Found((), ()), quick=False)
    assert "NOT MET" not in capsys.readouterr().out


def test_what_is_declared_about_the_vertical_axis():
    tilted = np.array([0.0, np.sin(0.02), np.cos(0.02)])
    symmetric = symmetry_scores._score_axis(Symmetry(-tilted, np.zeros(3), 9), np.array([0.0, 0, 1]))
    assert symmetric == Axis(9, "symmetry", pytest.approx(np.degrees(0.02)))
    free = symmetry_scores._score_axis(Freedom("turn", tilted, np.zeros(3)), np.array([0.0, 0, 1]))
    level = Axis(2, "symmetry", 90.0)
    gear = Case("gear18", 60)
    for axes, expected in (
        ((level,), "none"), ((level, symmetric), "multiple"), ((symmetric, free), "any"),
        ((replace(symmetric, order=18), level), "exact"), ((replace(symmetric, order=4),), "another"),
        ((Axis(None, "shift", 0.0),), "none"),
    ):  # fmt: skip
        assert name_order(score_of(gear, axes=axes)) == expected
