"""The user's step: chosen within what is open, refused where the session decides against it."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.ambiguity.known_step import (
    AGAINST_STEP,
    STEP,
    distrust,
    is_refuted,
    misses_by,
    use_step,
)
from orbitscan.recorder import poses
from tests.geometry import scan
from tests.processing.scene import SETTINGS, Scene, edge

UP = np.array([0.0, -1, 0])  # a camera's y points down


def turned(degrees):
    """T_target_source of a camera that goes round counterclockwise, an object 1 m before it."""
    return poses.turn_about(-UP, np.array([0, 0, 1.0]), np.radians(-degrees))


@pytest.mark.parametrize("step_deg", [20, -20, 90, 179, -179])
def test_a_turn_misses_itself_by_nothing_and_its_opposite_by_twice_as_much(step_deg):
    assert misses_by(turned(step_deg), step_deg) == pytest.approx(0, abs=1e-6)
    assert misses_by(turned(step_deg), step_deg + 360) == pytest.approx(0, abs=1e-6)
    assert misses_by(turned(step_deg), -step_deg) == pytest.approx(min(2 * abs(step_deg), 360 - 2 * abs(step_deg)))


def test_the_step_is_refuted_where_more_pairs_decide_against_it_than_go_by_it():
    by_step = replace(edge(1, 0, np.eye(4)), start=STEP)
    against = replace(edge(2, 1, np.eye(4), status="inconsistent"), note=AGAINST_STEP)
    free = edge(3, 2, np.eye(4))
    assert not is_refuted([by_step, free])
    assert not is_refuted([by_step, against, free])
    assert is_refuted([by_step, against, against])
    assert distrust(by_step).status == "inconsistent"
    assert distrust(by_step).note == AGAINST_STEP
    assert distrust(free) is free


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=2, points=4_000))


@pytest.mark.parametrize("miss_deg", [0.0, 1.0, 3.0, 4.8])
def test_a_pose_is_known_no_better_than_it_meets_the_step(scene, miss_deg):
    pair = scene.pair(scene.views[1], scene.views[0], replace(SETTINGS.pair, step_deg=20.0))
    exact = np.diag([1e-8] * 3 + [1e-10] * 3)
    found = use_step(pair, edge(1, 0, turned(20 + miss_deg), np.array([0, 0, 1.0]), covariance=exact))
    assert found.status == "ok"
    assert found.rotation_bound_deg == pytest.approx(max(miss_deg, 0.02), abs=0.05 * miss_deg + 0.02)
    assert found.center_bound_m < 1e-4


def test_what_misses_the_step_by_more_is_decided_against(scene):
    pair = scene.pair(scene.views[1], scene.views[0], replace(SETTINGS.pair, step_deg=20.0))
    assert use_step(pair, edge(1, 0, turned(26), np.array([0, 0, 1.0]))).status == "inconsistent"
