"""The joint refinement of whole sessions: what overlaps is found, in whatever order it came."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.pipeline import process
from orbitscan.processing.reconstruction.joint_refinement import refine_jointly
from orbitscan.processing.reconstruction.pose_graph import GraphSettings
from orbitscan.processing.reconstruction.session_evidence import reconsider
from orbitscan.processing.results.estimates import MethodResult, ViewEstimate
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses
from orbitscan.recorder.session import in_memory
from tests.geometry import blob, bottle, random_pose, scan
from tests.processing.scene import SETTINGS, Scene, degrees, edge


def run(session):
    """The session's last word, by both methods."""
    *_, last = process(session.views(), session.info, methods=("pairwise", "refined"))
    return last.reconstruction


def rearranged(session, order, replaced=None):
    """Some views of a session in another order, with other points in some places."""
    views, truth = [], session.truth()
    for i, j in enumerate(order):
        view = (replaced or {}).get(i) or session.load(j)
        views.append(replace(view, index=i, name=f"view_{i:03d}"))
    return in_memory(replace(session.info, views=len(views)), views, {i: truth[j] for i, j in enumerate(order)})


def errors_deg(session, found):
    """View -> how far its pose is off, for all that are placed."""
    truth = session.truth()
    origin = poses.invert(truth[found.origin])
    return {v.view: degrees(v.T_0_i, origin @ truth[v.view]) for v in found.views if v.T_0_i is not None}


def statuses(found):
    return [view.status for view in found.views]


@pytest.fixture(scope="module")
def arc():
    """Seven views, 25 degrees from one to the next."""
    return scan(n_views=7, step_deg=25, points=8_000)


@pytest.fixture(scope="module")
def in_order(arc):
    return run(arc)


def test_it_is_better_than_composing(arc, in_order):
    composed, refined = (errors_deg(arc, in_order[method]) for method in ("pairwise", "refined"))
    assert statuses(in_order["refined"]) == ["ok"] * 7
    assert (in_order["refined"].views[0].T_0_i == np.eye(4)).all()
    assert max(refined.values()) < 0.7
    assert np.mean(list(refined.values())) < np.mean(list(composed.values()))
    assert not in_order["refined"].loop_closed
    assert in_order["refined"].freedoms == ()


def test_views_that_overlap_are_joined_besides_those_in_sequence(in_order):
    pairs = [frozenset((p.source, p.target)) for p in in_order["refined"].pairs]
    assert len(set(pairs)) == len(pairs)
    assert any(max(pair) - min(pair) > 1 for pair in pairs)
    assert {frozenset((i, i - 1)) for i in range(1, 7)} <= set(pairs)


def test_two_views_are_the_pair(arc):
    found = run(rearranged(arc, [0, 1]))
    (pair,) = found["pairwise"].pairs
    assert np.allclose(found["refined"].views[1].T_0_i, pair.T_target_source, atol=1e-9)


def test_shuffled_views_are_all_placed(arc):
    session = rearranged(arc, [3, 0, 6, 2, 5, 1, 4])
    found = run(session)
    assert statuses(found["refined"]) == ["ok"] * 7
    assert max(errors_deg(session, found["refined"]).values()) < 0.7


def test_a_broken_pair_in_the_middle_is_bridged(arc):
    """The camera jumps to the far end of the arc and comes back."""
    session = rearranged(arc, [0, 1, 6, 5, 4, 3, 2])
    found = run(session)
    assert statuses(found["refined"]) == ["ok"] * 7
    assert max(errors_deg(session, found["refined"]).values()) < 0.7


def test_a_view_that_fits_nowhere_is_not_connected_and_harms_nothing(arc):
    other = scan(n_views=1, surface=bottle, points=8_000).load(0)
    session = rearranged(arc, range(5), {2: other})
    found = run(session)["refined"]
    assert statuses(found) == ["ok", "ok", "not_connected", "ok", "ok"]
    assert found.views[2].T_0_i is None
    assert max(errors_deg(session, found).values()) < 0.7


@pytest.mark.parametrize("at", [0, 4])
def test_a_foreign_view_at_an_end_costs_no_other(arc, at):
    other = scan(n_views=1, surface=bottle, points=8_000).load(0)
    session = rearranged(arc, range(5), {at: other})
    for found in run(session).values():
        assert [view.view for view in found.views if view.status != "ok"] == [at]
        assert found.views[at].T_0_i is None
        assert found.origin == (1 if at == 0 else 0)
        assert max(errors_deg(session, found).values()) < 0.7


def mirrored(rng, points):
    """Another surface without symmetry."""
    return tuple(rows * np.array([-1, 1, 1]) for rows in blob(rng, points))


def test_halves_that_share_nothing_each_hold_together(arc):
    """The larger is in frame {0}, the other in the frame of its own first view; both have a model."""
    other = scan(n_views=2, step_deg=25, surface=mirrored, points=8_000)
    session = rearranged(arc, [0, 1, 0, 1, 2], {i: other.load(i) for i in (0, 1)})
    *_, last = process(session.views(), session.info, methods=("icp", "pairwise", "refined"))
    truth, own = session.truth(), other.truth()
    for method in ("pairwise", "refined"):
        found = last.reconstruction[method]
        assert [view.component for view in found.views] == [1, 1, 0, 0, 0]
        assert statuses(found) == ["not_connected", "not_connected", "ok", "ok", "ok"]
        assert degrees(found.views[4].T_0_i, poses.invert(truth[2]) @ truth[4]) < 0.7
        assert degrees(found.views[1].T_component_i, poses.invert(own[0]) @ own[1]) < 0.7
        assert "one of 2 views that hold together" in found.views[0].note
    assert last.origin == 2
    assert (last.reconstruction["icp"].views[2].T_0_i == np.eye(4)).all()
    assert len(last.model.points) > len(last.model_apart.points) > 500


def test_views_of_a_bottle_hold_together_without_a_foreign_first(arc):
    bottles = scan(n_views=4, step_deg=20, surface=bottle, points=6_000)
    session = rearranged(bottles, range(4), {0: arc.load(0)})
    found = run(session)["refined"]
    assert found.origin == 1
    assert statuses(found) == ["not_connected", "ok", "ambiguous", "ambiguous"]
    assert [view.component for view in found.views] == [None, 0, 0, 0]


def test_a_refused_pair_that_others_bear_out_is_right(ready):
    refused = replace(exact(ready, 2, 1), status=Status.DIVERGED)
    known = pairwise_of(ready, [exact(ready, 1, 0), refused, exact(ready, 3, 2)])
    refined = refine_jointly(known, ready, ready_register(ready), SETTINGS.pair, GraphSettings())
    found = reconsider(known, refined, ready, SETTINGS.pair)
    assert statuses(refined) == statuses(found) == ["ok"] * 4
    wrong = replace(refused, T_target_source=random_pose(np.random.default_rng(0)))
    known = pairwise_of(ready, [exact(ready, 1, 0), wrong, exact(ready, 3, 2)])
    refined = refine_jointly(known, ready, ready_register(ready), SETTINGS.pair, GraphSettings())
    assert statuses(reconsider(known, refined, ready, SETTINGS.pair))[2:] == ["not_connected"] * 2


def test_a_full_circle_is_closed():
    session = scan(n_views=12, step_deg=30, points=6_000)
    found = run(session)
    assert statuses(found["refined"]) == ["ok"] * 12
    assert found["refined"].loop_closed
    assert frozenset((0, 11)) in {frozenset((p.source, p.target)) for p in found["refined"].pairs if p.status == "ok"}
    refined, composed = (errors_deg(session, found[m]) for m in ("refined", "pairwise"))
    assert max(refined.values()) < 1
    assert refined[11] < max(0.5, composed[11])


def test_a_short_arc_is_no_loop_however_far_apart_its_views_are_joined():
    found = run(scan(n_views=4, step_deg=20, points=6_000))["refined"]
    assert max(abs(p.source - p.target) for p in found.pairs) == 3
    assert not found.loop_closed


def test_a_bottles_views_are_ambiguous_about_its_axis():
    session = scan(n_views=3, step_deg=20, surface=bottle, points=6_000)
    found = run(session)["refined"]
    assert statuses(found) == ["ok", "ambiguous", "ambiguous"]
    (freedom,) = found.freedoms
    T_0_object = poses.invert(session.truth()[0])
    assert freedom.kind == "turn"
    assert abs(freedom.axis @ T_0_object[:3, 2]) > np.cos(np.radians(1))
    assert np.linalg.norm(np.cross(freedom.point - T_0_object[:3, 3], freedom.axis)) < 0.001


@pytest.fixture(scope="module")
def ready(arc):
    return Scene(rearranged(arc, [0, 1, 2, 3]))


def pairwise_of(ready, pairs, placed="ok"):
    views = [ViewEstimate(0, Status.OK, np.eye(4))]
    views += [ViewEstimate(i, placed, ready.T(0, i)) for i in range(1, len(ready.views))]
    return MethodResult(tuple(views), tuple(pairs))


def jointly(ready, pairs, register):
    how = SETTINGS.pair, GraphSettings()
    return refine_jointly(pairwise_of(ready, pairs), ready, register, *how)


def exact(ready, source, target):
    center = ready.views[target].surface.surfels.points.mean(axis=0)
    return edge(source, target, ready.T(target, source), center)


def ready_register(ready):
    return lambda source, target, hints: ready.register(source, target)


def never(source, target, hints):
    return replace(edge(source.view, target.view, np.eye(4)), status=Status.DIVERGED)


def test_pairs_without_an_end_in_the_graph_keep_their_status(ready):
    """Two views that fit each other but nothing else are not connected; their pair contradicts nobody."""
    found = jointly(ready, [exact(ready, 1, 0), exact(ready, 3, 2)], never)
    assert statuses(found) == ["ok", "ok", "not_connected", "not_connected"]
    assert {(p.source, p.target): p.status for p in found.pairs}[3, 2] == "ok"


def test_only_views_that_nothing_connects_are_registered_anew(ready):
    asked = []

    def register(source, target, hints):
        if not hints.starts:
            asked.append((source.view, target.view))
        return ready.register(source, target)

    found = jointly(ready, [exact(ready, 1, 0), exact(ready, 3, 1)], register)
    assert {source for source, _ in asked} == {2}
    assert statuses(found) == ["ok"] * 4


def test_a_pair_that_holds_a_view_to_one_just_attached_is_not_registered_again(ready):
    asked = []

    def register(source, target, hints):
        asked.append((source.view, target.view))
        return ready.register(source, target)

    found = jointly(ready, [exact(ready, 1, 0), exact(ready, 3, 2)], register)
    assert statuses(found) == ["ok"] * 4
    assert (2, 1) in asked
    assert (3, 2) not in asked
    assert len({frozenset((p.source, p.target)) for p in found.pairs}) == len(found.pairs)


def test_a_pair_that_is_not_believed_is_no_edge(ready):
    wrong = random_pose(np.random.default_rng(0))
    refuted = replace(exact(ready, 2, 1), T_target_source=wrong, status=Status.DIVERGED)
    assert jointly(ready, [exact(ready, 1, 0), refuted], never).views[2].status == "not_connected"


def test_a_view_is_not_ok_by_a_pair_that_leaves_something_open(ready):
    either = replace(exact(ready, 2, 1), status=Status.AMBIGUOUS, alternatives=(np.eye(4),))
    found = jointly(ready, [exact(ready, 1, 0), either, exact(ready, 3, 2)], never)
    assert statuses(found) == ["ok", "ok", "ambiguous", "ambiguous"]
    assert np.allclose(found.views[3].T_0_i, ready.T(0, 3), atol=1e-6)


def test_without_an_origin_there_is_nothing_to_refine():
    views = (ViewEstimate(0, Status.TOO_FEW_POINTS, None), ViewEstimate(1, Status.UNREADABLE, None))
    found = refine_jointly(MethodResult(views, ()), None, None, SETTINGS.pair, GraphSettings())
    assert statuses(found) == ["too_few_points", "unreadable"]
    assert found.summary["failed_views"] == 2


def test_where_nothing_moves_no_view_is_ok():
    """A camera that stands still before a wall registers the wall, whatever turns in front of it."""
    session = scan(n_views=3, step_deg=0, points=6_000)
    found = run(session)
    for method in ("pairwise", "refined"):
        assert statuses(found[method]) == ["ok", "inconsistent", "inconsistent"]
        assert all("nothing moves" in view.note for view in found[method].views[1:])


def test_a_view_of_another_size_is_not_ok_and_says_so(arc):
    """A camera that measures 3 % more than the others, or a unit that is nearly another: no pose makes up for it."""
    view = arc.load(2)
    larger = replace(view, points=(1.03 * view.points).astype(np.float32))
    found = run(rearranged(arc, [0, 1, 2, 3, 4], {2: larger}))
    for method in ("pairwise", "refined"):
        assert [view.view for view in found[method].views if view.status != "ok"] == [2]
        assert found[method].views[2].status == "inconsistent"
        assert "% larger" in found[method].views[2].note
