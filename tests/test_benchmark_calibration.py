"""The benchmark of bounds: which sessions it runs, and what it counts as within a bound."""

from orbitscan.processing.results.status import Status
from tests.benchmarks import calibration
from tests.benchmarks.symmetry_scores import Case, Found, MethodScore, PairScore, Score, ViewScore


def score(case):
    """Two ok views, one within its bound, and an ambiguous one that does not count; pairs alike."""
    views = tuple(
        ViewScore(i, status, off, 0.001, 0.5, 0.002)
        for i, (status, off) in enumerate([(Status.OK, 0.3), (Status.OK, 6.0), (Status.AMBIGUOUS, 90.0)], 1)
    )
    pairs = tuple(PairScore(v.view, 0, v.status, v.degrees, 0.001, 0.5, 0.002, (), 0) for v in views)
    return Score(case, 0.1, 1.0, dict.fromkeys(("pairwise", "refined"), MethodScore(views, pairs, ())))


def test_every_object_is_seen_at_both_steps_by_both_sensors():
    whole = calibration.whole()
    assert len(set(whole)) == len(whole)
    seen = {(case.object, case.instance, case.step, case.sensor) for case in whole}
    objects = {(case.object, case.instance) for case in whole}
    assert len(seen) == len(whole) == 4 * len(objects)
    assert {case.noise for case in whole if case.sensor == "gaussian"} == set(calibration.NOISE)


def test_ok_ones_are_counted_within_their_bounds_and_wrong_ones_are_told(capsys):
    scores = [score(Case("robot", 20)), score(Case("robot", 30, sensor="kinect"))]
    for method in ("pairwise", "refined"):
        known = calibration.collect(scores, method)
        assert len(known) == 4
        assert sum(entry.degrees <= entry.bound_deg for entry in known) == 2
        assert sum(entry.wrong for entry in known) == 2
    calibration.report(Found(tuple(scores), ("robot 40 deg: broke",)))
    printed = capsys.readouterr().out
    assert printed.count("2 of 4 = 50.00 %") == 4  # robot and all, pairs and views
    assert "50 %" in printed
    assert "broken: robot 40 deg: broke" in printed
