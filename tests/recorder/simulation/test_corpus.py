import math
from dataclasses import replace

import numpy as np
import pytest

from orbitscan.recorder import mcap_file
from orbitscan.recorder.exceptions import InvalidOption, UnwritableOutput
from orbitscan.recorder.simulation.corpus import CAMERA, INSTANCES, Circle, open_circle, plan, record, record_all

QUICK = replace(CAMERA, every=100)


def test_the_thesiss_table_gives_its_circles():
    circles = plan(INSTANCES)
    assert len(INSTANCES) == 10
    assert len(circles) == len({circle.name for circle in circles}) == 61 * 3
    assert {circle.video for circle in circles} == {1, 2, 4}
    assert circles[0].name == "apple_1_1"
    assert circles[-1] == Circle("water_bottle", 10, 4)


@pytest.mark.parametrize(
    ("category", "degrees"), [("bowl", -180), ("cap", -30), ("coffee_mug", -45), ("stapler", -180)]
)
def test_a_circle_starts_half_a_run_before_the_front(category, degrees):
    assert Circle(category, 1, 1).start_deg == degrees


@pytest.mark.parametrize(("category", "runs"), [("cap", 6), ("coffee_mug", 4)])
def test_the_middle_of_the_first_run_sees_the_front(category, runs):
    camera = replace(CAMERA, views=240)
    place = open_circle(Circle(category, 2, 2), camera).truth()[240 // runs // 2][:3, 3]
    assert math.degrees(math.atan2(place[1], place[0])) == pytest.approx(0, abs=1e-9)


def test_the_three_videos_look_from_three_heights():
    for video, elevation_deg in ((1, 30), (2, 45), (4, 60)):
        session = open_circle(Circle("bowl", 3, video), QUICK)
        assert (session.info.name, session.info.category, session.info.instance) == (f"bowl_3_{video}", "bowl", "3")
        assert (session.info.capture, session.info.elevation_deg) == ("circle", elevation_deg)
        down = session.truth()[0][2, 2]
        assert math.degrees(math.asin(-down)) == pytest.approx(elevation_deg)


def test_a_thinned_circle_is_a_part_of_the_whole_one():
    whole = open_circle(Circle("coffee_mug", 2, 1), replace(CAMERA, views=20))
    thin = open_circle(Circle("coffee_mug", 2, 1), replace(CAMERA, views=20, every=7))
    assert (thin.info.views, thin.info.views_per_turn) == (3, pytest.approx(20 / 7))
    for index in range(3):
        np.testing.assert_allclose(thin.truth()[index], whole.truth()[7 * index], atol=1e-12)
        np.testing.assert_array_equal(thin.load(index).points, whole.load(7 * index).points)


def test_a_recording_that_is_there_is_kept_and_another_one_is_refused(tmp_path):
    circle = Circle("bowl", 1, 4)
    first = record(circle, tmp_path, QUICK)
    content = first.path.read_bytes()
    assert (first.path.name, first.views, first.kept) == ("bowl_1_4.mcap", 2, False)
    assert mcap_file.read(first.path).info == open_circle(circle, QUICK).info
    assert record(circle, tmp_path, QUICK).kept
    with pytest.raises(UnwritableOutput, match=r"bowl_1_4\.mcap: was recorded with other options"):
        record(circle, tmp_path, replace(QUICK, seed=1))
    assert first.path.read_bytes() == content


def test_workers_write_the_same_bytes(tmp_path):
    circles = plan({"bowl": 1})
    alone = {found.path.name: found.path.read_bytes() for found in record_all(circles, tmp_path / "1", QUICK)}
    both = {found.path.name: found.path.read_bytes() for found in record_all(circles, tmp_path / "2", QUICK, 2)}
    assert sorted(alone) == ["bowl_1_1.mcap", "bowl_1_2.mcap", "bowl_1_4.mcap"]
    assert alone == both


def test_a_corpus_does_not_fit_one_file(tmp_path):
    with pytest.raises(InvalidOption, match="3 recordings do not fit one file; give a folder"):
        next(record_all(plan({"bowl": 1}), tmp_path / "x.mcap", QUICK))
