"""What colours decide of a pair that its shapes leave open, and what they do not."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from orbitscan.processing.reconstruction.trajectory import Hints
from orbitscan.processing.registration.color.decision import COLOR, doubt_color, use_color
from orbitscan.processing.results.estimates import Symmetry
from orbitscan.recorder import poses
from orbitscan.recorder.session import first_views
from orbitscan.recorder.simulation.camera import simulate
from tests.benchmarks.solids import SOLIDS
from tests.processing.scene import SETTINGS, Scene, degrees

SHAPE_ALONE = replace(SETTINGS.pair, color=False)


def scene(folder, name, views, **looks):
    solid = SOLIDS[name].write(folder) if name in SOLIDS else name
    return Scene(first_views(simulate(solid, views=views, color_noise=3, **looks), 2))


def open_pair(scene):
    """The pair by its shapes, which leave it open."""
    pair = scene.pair(scene.views[1], scene.views[0], SHAPE_ALONE)
    found = scene.steps().register_competing(pair, scene.correspond(scene.views[1], scene.views[0]), Hints())
    assert found.status == "ambiguous"
    return scene.pair(scene.views[1], scene.views[0]), found


@pytest.fixture(scope="module")
def printed(tmp_path_factory):
    return scene(tmp_path_factory.mktemp("prism"), "prism06", 8, paint="print", lamp="camera", gloss=0.3)


@pytest.mark.parametrize("name", ["prism06", "water_bottle", "plate"])
def test_a_print_leaves_one_pose(tmp_path, name):
    body = scene(tmp_path, name, 12, paint="print", lamp="room", gloss=0.3)
    pair, left = open_pair(body)
    found = use_color(pair, left)
    assert (found.status, found.start) == ("ok", COLOR)
    assert (found.freedoms, found.symmetries, found.alternatives) == ((), (), ())
    assert degrees(found.T_target_source, body.T(0, 1)) < found.rotation_bound_deg < 3
    assert found.evidence.color_misfit < 2


@pytest.mark.parametrize("lamp", ["object", "camera", "room"])
def test_a_plain_body_stays_open_in_any_light(tmp_path, lamp):
    pair, left = open_pair(scene(tmp_path, "water_bottle", 12, paint="plain", lamp=lamp, gloss=0.5))
    assert use_color(pair, left) is left


def test_the_number_of_threads_changes_no_bit(tmp_path):
    found = []
    for threads in (1, 2):
        body = scene(tmp_path, "water_bottle", 6, paint="print", lamp="room", gloss=0.3)
        pair, left = open_pair(body)
        with threadpool_limits(threads, user_api="blas"):
            found.append(use_color(pair, left))
    assert found[0].start == COLOR
    assert np.array_equal(found[0].T_target_source, found[1].T_target_source)
    assert np.array_equal(found[0].covariance, found[1].covariance)


def test_shuffled_colours_decide_nothing(printed):
    rng = np.random.default_rng(0)
    shuffled = [replace(v, surface=replace(v.surface, colors=rng.permutation(v.surface.colors))) for v in printed.views]
    _, left = open_pair(printed)
    assert use_color(printed.pair(shuffled[1], shuffled[0]), left) is left


def test_a_setting_leaves_colours_out(printed):
    pair, left = open_pair(printed)
    assert use_color(replace(pair, settings=SHAPE_ALONE), left) is left


def test_what_colours_repeat_out_of_sight_stays_open(printed):
    """A pair says nothing of a turn that brings what it shows where it does not look."""
    pair, left = open_pair(printed)
    found = use_color(pair, left)
    T_0 = printed.truth[0]
    upright, level, point = T_0[2, :3], T_0[1, :3], poses.transform(poses.invert(T_0), np.zeros((1, 3)))[0]
    beside, upside_down = Symmetry(upright, point, 6), Symmetry(level, point, 2)
    doubted = doubt_color(pair, found, [beside, upside_down])
    assert (doubted.status, doubted.symmetries) == ("ambiguous", (upside_down,))
    assert doubt_color(pair, found, [beside]) is found
    assert doubt_color(pair, left, [upside_down]) is left
