"""The graph of pairs: exact without noise, better than chaining with it, not led astray by one false edge."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from orbitscan.processing.reconstruction.graph_solver import Measurements
from orbitscan.processing.reconstruction.pose_graph import GraphSettings, place, solve
from orbitscan.processing.results.estimates import Freedom
from orbitscan.processing.results.status import Status
from orbitscan.recorder import poses
from tests.geometry import random_pose
from tests.processing.scene import degrees, edge

HOW = GraphSettings()
DIAMETER = 0.3  # of the object [m]
TURN, SHIFT = 0.01, 0.001  # deviations of an edge [rad] and [m], as `edge` states them


def ring(rng, n):
    """Poses T_0_i of n cameras round an object, somewhat shaken; the first is the origin."""
    cameras = []
    for i in range(n):
        T = poses.make(Rotation.from_euler("y", 360 * i / n, degrees=True).as_matrix(), np.zeros(3))
        cameras.append(T @ poses.make(np.eye(3), [0, 0, -1.0]) @ random_pose(rng, angle=0.1, shift=0.05))
    return [poses.invert(cameras[0]) @ T for T in cameras]


def pairs(n, across=()):
    """Successive views of a ring, the closing pair, and those so many views apart."""
    apart = [(i, (i - k) % n) for k in across for i in range(n)]
    return [(i, i - 1) for i in range(1, n)] + [(0, n - 1), *apart]


def measure(T_0, which, rng=None):
    """Edges of the pairs, with errors as large as the edges say where there is a generator."""
    edges = []
    for source, target in which:
        T, center = poses.invert(T_0[target]) @ T_0[source], np.array([0, 0, 1.0])
        if rng is not None:
            R = Rotation.from_rotvec(rng.normal(scale=TURN, size=3)).as_matrix()
            T = poses.make(R, center - R @ center + rng.normal(scale=SHIFT, size=3)) @ T
        edges.append(edge(source, target, T, center))
    return edges


def worst_deg(solution, T_0):
    return max(degrees(T, T_0[view]) for view, T in solution.T_0.items())


@settings(max_examples=15)
@given(st.integers(0, 10**6), st.integers(4, 12))
def test_without_noise_it_is_exact(seed, n):
    T_0 = ring(np.random.default_rng(seed), n)
    solution = solve(measure(T_0, pairs(n, across=(2,))), range(n), DIAMETER, HOW)
    assert solution.rigid == set(range(n))
    assert all(solution.kept)
    assert (solution.T_0[0] == np.eye(4)).all()
    for view, T in solution.T_0.items():
        assert np.allclose(T, T_0[view], atol=1e-7)


def test_it_beats_chaining():
    chained, solved = [], []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        T_0 = ring(rng, 12)
        edges = measure(T_0, pairs(12, across=(2, 3)), rng)
        at = np.eye(4)
        for i in range(1, 12):
            at = at @ edges[i - 1].T_target_source
        chained.append(degrees(at, T_0[11]))
        solution = solve(edges, range(12), DIAMETER, HOW)
        assert solution.rigid == set(range(12))
        solved.append(worst_deg(solution, T_0))
    assert np.median(solved) < np.median(chained) / 1.5
    assert np.median(solved) < 2 * np.degrees(TURN)


def test_the_poses_fit_the_edges_best():
    """No pose moved a little fits all edges better: it is a minimum."""
    rng = np.random.default_rng(1)
    T_0 = ring(rng, 6)
    edges = measure(T_0, pairs(6, across=(2,)), rng)
    solution = solve(edges, range(6), DIAMETER, replace(HOW, outlier=1e6, iterations=50))

    def cost(at):
        total = 0.0
        for e in edges:
            D = poses.invert(at[e.target]) @ at[e.source] @ poses.invert(e.T_target_source)
            turn = Rotation.from_matrix(D[:3, :3]).as_rotvec()
            r = np.concatenate([turn, poses.transform(D, e.center[None])[0] - e.center])
            total += r @ e.information @ r
        return total

    least = cost(solution.T_0)
    for seed in range(30):
        off = random_pose(np.random.default_rng(seed), angle=0.003, shift=0.0003)
        view = 1 + seed % 5
        assert cost({**solution.T_0, view: off @ solution.T_0[view]}) > least
    assert cost(dict(enumerate(T_0))) > least


@pytest.mark.parametrize("false", range(0, 30, 3))
def test_one_false_edge_is_left_out(false):
    rng = np.random.default_rng(2)
    T_0 = ring(rng, 10)
    edges = measure(T_0, pairs(10, across=(2, 3)), rng)
    edges[false] = replace(edges[false], T_target_source=random_pose(rng, 1.5, 0.1) @ edges[false].T_target_source)
    solution = solve(edges, range(10), DIAMETER, HOW)
    assert not solution.kept[false]
    assert sum(solution.kept) >= len(edges) - 2
    assert worst_deg(solution, T_0) < 3 * np.degrees(TURN)


def test_a_false_edge_that_sounds_most_confident_is_left_out_too():
    """First poses go along the most confident edges: a false one among them puts half a ring in the wrong place."""
    rng = np.random.default_rng(2)
    T_0 = ring(rng, 10)
    edges = measure(T_0, pairs(10, across=(2, 3)), rng)
    wrong = random_pose(rng, 1.0, 0.1) @ edges[4].T_target_source
    edges[4] = replace(edges[4], T_target_source=wrong, confidence=0.99)
    solution = solve(edges, range(10), DIAMETER, HOW)
    assert not solution.kept[4]
    assert worst_deg(solution, T_0) < 3 * np.degrees(TURN)


def test_what_nothing_connects_is_placed_apart():
    T_0 = ring(np.random.default_rng(0), 7)
    solution = solve(measure(T_0, [(1, 0), (3, 2), (4, 3), (5, 4)]), range(7), DIAMETER, HOW)
    assert [component.first for component in solution.components] == [2, 0, 6]
    assert [set(component.T) for component in solution.components] == [{2, 3, 4, 5}, {0, 1}, {6}]
    assert all(solution.kept)  # nothing contradicts them
    assert solution.origin == 2
    for component in solution.components:
        assert component.rigid == set(component.T)
        for view, T in component.T.items():
            assert np.allclose(T, poses.invert(T_0[component.first]) @ T_0[view], atol=1e-7)


def test_views_alone_are_each_a_component():
    solution = solve([], [3, 1], DIAMETER, HOW)
    assert [component.first for component in solution.components] == [3, 1]  # in the order of use


def test_what_held_before_stays_first_and_views_that_are_ambiguous_count_too():
    T_0 = ring(np.random.default_rng(0), 8)
    edges = [free_turn(T_0, 1, 0), free_turn(T_0, 2, 1), *measure(T_0, [(4, 3), (5, 4), (7, 6)])]
    assert solve(edges, range(8), DIAMETER, HOW).origin == 3
    assert solve(edges, range(8), DIAMETER, HOW, before=[1, 2]).origin == 0
    assert [c.first for c in solve(edges[:2], range(4), DIAMETER, HOW).components] == [0, 3]
    assert solve([free_turn(T_0, 2, 1)], range(3), DIAMETER, HOW).origin == 1


def test_of_equal_components_the_earlier_is_the_first():
    T_0 = ring(np.random.default_rng(0), 4)
    edges = measure(T_0, [(1, 0), (3, 2)])
    assert solve(edges, range(4), DIAMETER, HOW).origin == 0
    assert solve(edges, [2, 3, 0, 1], DIAMETER, HOW).origin == 2


def free_turn(T_0, source, target, angle=0.4):
    """An edge that leaves the turn about the ring's axis free, and is off by an angle [rad] in it."""
    e = measure(T_0, [(source, target)])[0]
    axis = poses.invert(T_0[target])[:3, :3] @ np.array([0, 1.0, 0])
    point = e.center + np.array([0.01, 0, 0])
    T = poses.turn_about(axis, point, angle) @ e.T_target_source
    return replace(e, T_target_source=T, status=Status.AMBIGUOUS, freedoms=(Freedom("turn", axis, point),))


def test_views_behind_free_edges_are_placed_but_not_rigid():
    T_0 = ring(np.random.default_rng(0), 6)
    edges = measure(T_0, [(1, 0), (2, 1), (4, 3)])
    edges.insert(2, free_turn(T_0, 3, 2))
    solution = solve(edges, range(6), DIAMETER, HOW)
    assert set(solution.T_0) == {0, 1, 2, 3, 4}
    assert solution.rigid == {0, 1, 2}
    assert all(solution.kept)


@pytest.mark.parametrize("angle", [0.4, 2.0, -3.0])
def test_a_free_direction_does_not_pull(angle):
    """Other edges know the turn that two leave free: the poses take it from there, and nothing contradicts."""
    rng = np.random.default_rng(0)
    T_0 = ring(rng, 6)
    firm = measure(T_0, pairs(6, across=(2,)), rng)
    free = [free_turn(T_0, 2, 1, angle), free_turn(T_0, 5, 4, angle)]
    solution = solve([*firm, *free], range(6), DIAMETER, HOW)
    assert solution.rigid == set(range(6))
    assert worst_deg(solution, T_0) < worst_deg(solve(firm, range(6), DIAMETER, HOW), T_0) + 0.1
    assert all(solution.kept)


def test_an_edge_still_holds_what_it_does_not_leave_free():
    T_0 = ring(np.random.default_rng(0), 3)
    free = free_turn(T_0, 1, 0)
    solution = solve([free, free_turn(T_0, 2, 1)], range(3), DIAMETER, HOW)
    axis = free.freedoms[0].axis
    off = (solution.T_0[1] @ poses.invert(T_0[1]))[:3, :3]
    assert np.allclose(off @ axis, axis, atol=1e-6)


def test_the_frame_is_that_of_a_view_that_nothing_is_open_of():
    """A first view that hangs on a free edge is placed, but no pose is told from it."""
    T_0 = ring(np.random.default_rng(0), 5)
    solution = solve([free_turn(T_0, 1, 0), *measure(T_0, [(2, 1), (3, 2), (4, 3)])], range(5), DIAMETER, HOW)
    assert solution.origin == 1
    assert set(solution.T_0) == set(range(5))
    assert solution.rigid == {1, 2, 3, 4}


def test_first_poses_follow_the_most_confident_edges():
    T_0 = ring(np.random.default_rng(0), 3)
    sure = measure(T_0, [(1, 0), (2, 1)])
    doubtful = replace(edge(2, 0, random_pose(np.random.default_rng(1))), confidence=0.1)
    found, tree = place([doubtful, *sure], [0] * (len(sure) + 1))
    assert all(np.allclose(found[view], T_0[view]) for view in range(3))
    assert tree == [1, 2]


def test_first_poses_follow_free_edges_only_where_there_are_no_others():
    T_0 = ring(np.random.default_rng(0), 4)
    free = [replace(free_turn(T_0, *pair), confidence=0.99) for pair in ((1, 0), (2, 1), (3, 2))]
    firm = measure(T_0, [(2, 0), (2, 1)])
    found, tree = place([*free, *firm], [0] * (len(free) + len(firm)))
    assert tree == [3, 4, 2]
    assert all(np.allclose(found[view], T_0[view]) for view in range(3))


def test_the_frame_is_that_of_the_view_used_first():
    T_0 = ring(np.random.default_rng(0), 5)
    solution = solve(measure(T_0, pairs(5)), [3, 0, 1, 2, 4], DIAMETER, HOW)
    assert list(solution.T_0) == [3, 0, 1, 2, 4]
    for view, T in solution.T_0.items():
        assert np.allclose(T, poses.invert(T_0[3]) @ T_0[view], atol=1e-7)


def test_a_long_ring_is_solved_below_its_noise():
    """250 views, 1,000 edges: the steps end before they are used up, and a good start is not needed."""
    rng = np.random.default_rng(3)
    T_0 = ring(rng, 250)
    edges = measure(T_0, pairs(250, across=(2, 5, 20)), rng)
    solution = solve(edges, range(250), DIAMETER, HOW)
    again = solve(edges, range(250), DIAMETER, replace(HOW, iterations=100))
    assert max(degrees(T, again.T_0[view]) for view, T in solution.T_0.items()) < 1e-3 * np.degrees(TURN)
    assert worst_deg(solution, T_0) < 10 * np.degrees(TURN)


def test_a_pair_without_information_is_no_edge():
    e = edge(1, 0, np.eye(4))
    assert len(Measurements.of([e], [0, 1]).source) == 1
    for missing in ("T_target_source", "information", "center"):
        with pytest.raises(ValueError, match="views 1 and 0"):
            Measurements.of([replace(e, **{missing: None})], [0, 1])
