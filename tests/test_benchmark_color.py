"""The benchmark of colours: which sessions it runs, and what it counts."""

from dataclasses import replace

from orbitscan.processing.results.status import Status
from tests.benchmarks import color
from tests.benchmarks.symmetry_scores import SCORE, Case, Found, MethodScore, PairScore, Score, ViewScore


def score(case, *statuses, degrees=0.2):
    """A session whose views have these statuses, each placed by colour."""
    views = tuple(ViewScore(i, status, degrees, 0.001, 0.5, 0.002) for i, status in enumerate(statuses, 1))
    pairs = tuple(PairScore(v.view, 0, v.status, degrees, 0.001, 0.5, 0.002, (), 0, "color") for v in views)
    return Score(case, 0.1, 1.0, {"refined": MethodScore(views, pairs, ())})


def test_every_family_is_printed_and_lit_in_every_way():
    whole = color.whole()
    assert len(set(whole)) == len(whole) <= 200
    printed = {(case.object, case.instance, case.lamp) for case in whole if case.paint == "print"}
    assert len(printed) == 3 * sum(map(len, color.FAMILIES.values()))
    assert {(case.lamp, case.sensor) for case in whole} == {(lamp, s) for lamp in color.LAMPS for s in color.SENSORS}
    plain = [case for case in whole if case.paint == "plain" and case.color]
    assert all(replace(case, color=False) in whole for case in plain)
    assert all(case.views <= 8 for case in color.slice_of_it())


def test_what_is_right_wrong_and_changed_is_told(capsys):
    plain = Case("bowl", 30, paint="plain", lamp="room")
    scores = (
        score(
            Case("prism06", 30, paint="print", lamp="room"), Status.OK, Status.OK, Status.AMBIGUOUS, Status.AMBIGUOUS
        ),
        score(Case("prism12", 30, paint="label", lamp="room"), Status.OK, degrees=30.0),
        score(plain, Status.OK),
        score(replace(plain, color=False), Status.AMBIGUOUS),
    )
    color.report(Found(scores, ("bowl: broke",)))
    printed = capsys.readouterr().out
    assert "2 = 50 %" in printed
    assert "wrong: prism12 30 deg 1 mm, label, lamp room: 1 by 30.0 deg" in printed
    assert "plain, but not as without colours:\nbowl 30 deg 1 mm, plain, lamp room" in printed
    assert "broken: bowl: broke" in printed


def test_scores_are_kept_and_read_again():
    kept = score(Case("bowl", 30, paint="plain", lamp="room", gloss=0.5, color=False), Status.OK)
    assert SCORE.validate_json(SCORE.dump_json(kept)) == kept
