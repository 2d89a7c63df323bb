"""What both sensors must see: a right pose explains it, a wrong one does not, and what overlaps more is no better."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.registration.covisibility import CovisibilitySettings, Explanation, explain
from orbitscan.processing.registration.encounter import EncounterSettings
from orbitscan.recorder import poses
from tests.geometry import scan
from tests.processing.scene import Scene

HOW = CovisibilitySettings()


@pytest.fixture(scope="module")
def scene():
    return Scene(scan(n_views=2, step_deg=30))


def of(scene, T, source=None, target=None):
    return explain(T, source or scene.views[1], target or scene.views[0], EncounterSettings(), HOW)


def test_the_right_pose_explains_what_both_see_as_noise_does(scene):
    right = of(scene, scene.T(0, 1))
    assert right.worse_than(right) == 0
    assert right.usual < 1.5
    assert np.isfinite(right.squares).mean() > 0.99


@pytest.mark.parametrize("turned_deg", [8, 30, 90])
def test_a_wrong_pose_explains_it_worse(scene, turned_deg):
    T = scene.T(0, 1)
    center = poses.transform(T, scene.views[1].surface.working).mean(axis=0)
    wrong = poses.turn_about(np.array([0.0, 1, 0]), center, np.radians(turned_deg)) @ T
    assert of(scene, wrong).worse_than(of(scene, T)) > HOW.worse
    assert of(scene, T).worse_than(of(scene, wrong)) < HOW.worse


def test_it_is_the_same_seen_from_either_view(scene):
    T = scene.T(0, 1)
    there, back = of(scene, T), of(scene, poses.invert(T), scene.views[0], scene.views[1])
    assert np.sort(there.squares) == pytest.approx(np.sort(back.squares))


def test_surfaces_that_do_not_meet_tell_nothing(scene):
    far = poses.make(np.eye(3), [0, 9.0, 0])
    nothing = of(scene, far)
    assert not len(nothing.squares)
    assert nothing.worse_than(of(scene, scene.T(0, 1))) == 0


def test_empty_directions_tell_only_where_the_recording_says_that_they_were_looked_at(scene):
    aside = poses.make(np.eye(3), [0.5 * scene.scale.diameter, 0, 0]) @ scene.T(0, 1)
    source, target = scene.views[1], scene.views[0]
    looked = replace(target, surface=replace(target.surface, outline_known=True))
    without, with_outline = of(scene, aside), of(scene, aside, source, looked)
    assert np.isinf(with_outline.squares).sum() > np.isinf(without.squares).sum()


def test_without_a_sensors_place_nothing_is_seen_through():
    scene = Scene(scan(n_views=2, step_deg=30))
    views = [scene.prepare(scene.session.load(i), sensor_origin=None) for i in (0, 1)]
    wrong = poses.make(np.eye(3), [0, 0, -0.3 * scene.scale.diameter]) @ scene.T(0, 1)
    assert np.isfinite(explain(wrong, views[1], views[0], EncounterSettings(), HOW).squares).all()


def test_a_noisy_sensor_needs_more_to_refute_a_pose():
    """Residuals are measured in what is usual: the same departures say less where all residuals are large."""
    rng = np.random.default_rng(0)
    patches = np.repeat(np.arange(100), 20)
    quiet = Explanation(rng.chisquare(1, 2000), patches, HOW)
    loud = Explanation(9 * rng.chisquare(1, 2000), patches, HOW)
    departed = rng.random(2000) < 0.05
    off = [replace(found, squares=found.squares + 12 * departed) for found in (quiet, loud)]
    assert off[0].worse_than(quiet) > 2 * off[1].worse_than(loud)


def test_neighbours_count_once():
    """What departs in a few patches is less than what departs everywhere, be it as much in all."""
    squares, departed = np.ones(2000), np.zeros(2000)
    departed[:100] = 5
    together = Explanation(squares, np.repeat(np.arange(100), 20), HOW)
    scattered = Explanation(squares, np.arange(2000), HOW)
    assert replace(scattered, squares=squares + departed).worse_than(scattered) > replace(
        together, squares=squares + departed
    ).worse_than(together)
