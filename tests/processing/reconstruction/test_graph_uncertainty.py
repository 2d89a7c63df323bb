"""The covariances of a graph's poses: against many solutions of the same graph with other noise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orbitscan.processing.reconstruction.graph_uncertainty import measure_graph
from orbitscan.processing.reconstruction.pose_graph import GraphSettings, solve
from orbitscan.processing.results.estimates import Evidence
from orbitscan.recorder import poses
from tests.processing.reconstruction.test_pose_graph import DIAMETER, ring
from tests.processing.scene import edge

CENTER = np.array([0.0, 0, 1.0])
TURN, SHIFT = 0.002, 0.0005  # deviations of a view's part in its pairs [rad] and [m]
RIGHT = np.diag([1 / TURN**2] * 3 + [1 / SHIFT**2] * 3) / 2
ALONE = Evidence(misfit=0.8, overlap=0.0)  # no noise is shared


def sessions(n, which, count, rng, worse=1.0):
    """Solutions of a ring's pairs, each with other errors, so many times as large as stated of them; the truth."""
    T_0 = ring(np.random.default_rng(1), n)
    found = []
    for _ in range(count):
        pairs = []
        for source, target in which:
            R = Rotation.from_rotvec(rng.normal(scale=worse * np.sqrt(2) * TURN, size=3)).as_matrix()
            noise = poses.make(R, CENTER - R @ CENTER + rng.normal(scale=worse * np.sqrt(2) * SHIFT, size=3))
            T = noise @ poses.invert(T_0[target]) @ T_0[source]
            given = {"information": RIGHT, "covariance": np.linalg.inv(RIGHT)}
            pairs.append(replace(edge(source, target, T, CENTER, **given), evidence=ALONE))
        found.append((solve(pairs, range(n), DIAMETER, GraphSettings()), pairs))
    return T_0, found


def share_within(which, worse=1.0):
    """The share of views that lie within their bounds, of 60 sessions of five views."""
    T_0, found = sessions(5, which, 60, np.random.default_rng(0), worse)
    within = []
    for solution, pairs in found:
        stated = measure_graph(pairs, solution.T_0, CENTER, 0)
        for view in range(1, 5):
            D = solution.T_0[view] @ poses.invert(T_0[view])
            within.append(np.degrees(poses.rotation_angle(D[:3, :3])) <= stated[view].rotation_bound_deg)
    return np.mean(within)


@pytest.mark.parametrize("extra", [(), ((0, 4),), ((0, 4), (2, 0), (3, 1))])
def test_a_chain_and_a_ring_are_known_as_well_as_they_scatter(extra):
    which = [(1, 0), (2, 1), (3, 2), (4, 3), *extra]
    assert 0.88 <= share_within(which) <= 0.995


def test_pairs_that_contradict_each_other_are_known_worse_than_they_say():
    which = [(1, 0), (2, 1), (3, 2), (4, 3), (0, 4), (2, 0), (3, 1), (4, 2), (0, 3), (1, 4)]
    assert 0.88 <= share_within(which, worse=4.0) <= 0.995


def test_the_end_of_a_chain_is_known_worse_than_its_beginning():
    _, ((solution, pairs),) = sessions(5, [(1, 0), (2, 1), (3, 2), (4, 3)], 1, np.random.default_rng(0))
    bounds = [found.rotation_bound_deg for found in measure_graph(pairs, solution.T_0, CENTER, 0).values()]
    assert (np.diff(bounds) > 0).all()


def test_the_noise_of_one_view_does_not_average_out_over_its_pairs():
    """Four pairs of a view to others that see the same of it say little more of its pose than one."""
    _, ((solution, pairs),) = sessions(
        5, [(4, 0), (4, 1), (4, 2), (4, 3), (1, 0), (2, 0), (3, 0)], 1, np.random.default_rng(0)
    )
    alone = measure_graph(pairs, solution.T_0, CENTER, 0)[4].rotation_bound_deg
    alike = [replace(pair, evidence=Evidence(misfit=0.8, overlap=1.0)) for pair in pairs]
    assert measure_graph(alike, solution.T_0, CENTER, 0)[4].rotation_bound_deg > 1.2 * alone


def test_a_session_of_one_view_has_nothing_to_know():
    assert measure_graph([], {0: np.eye(4)}, CENTER, 0) == {}


def test_a_pair_of_which_nobody_knows_how_well_is_refused():
    with pytest.raises(ValueError, match="views 1 and 0"):
        measure_graph([replace(edge(1, 0, np.eye(4)), covariance=None)], {0: np.eye(4), 1: np.eye(4)}, CENTER, 0)


def test_what_colours_are_off_adds_up_along_a_chain():
    """A camera puts all colours beside the surface alike: errors of a chain of such pairs do not average out."""
    T_0 = {view: np.eye(4) for view in range(5)}
    bounds = []
    for start in ("identity", "color"):
        pairs = [edge(view, view - 1, np.eye(4), start=start) for view in range(1, 5)]
        bounds.append(measure_graph(pairs, T_0, np.zeros(3), 0)[4].rotation_bound_deg)
    assert bounds[1] == pytest.approx(2 * bounds[0], rel=0.01)
