"""Azimuths that no view covers: whatever the frame, from the estimates alone, and nothing where it cannot be told."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbitscan.processing.reconstruction.coverage import CoverageSettings, find_gaps, find_up, measure_coverage
from orbitscan.processing.reconstruction.turntable import TurntableSettings, fit_turntable
from orbitscan.processing.results.records import Model
from orbitscan.processing.results.status import Method
from orbitscan.recorder import poses
from tests.geometry import random_pose

SEEDS = st.integers(0, 10**6)
CAMERA = (0.0, 0.0, 0.0)  # where a camera stands in its own frame
HOW = CoverageSettings()


def look(azimuth_deg, elevation_deg=30.0, distance=1.0):
    """T_object_camera of a level camera that looks at the origin, z up."""
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return poses.make(np.column_stack([right, np.cross(-back, right), -back]), distance * back)


def in_first_frame(T_object):
    """T_0_i by view, and the object's origin in frame {0}."""
    first = poses.invert(T_object[0])
    return {i: first @ T for i, T in enumerate(T_object)}, first[:3, 3]


def measure(T_0, sensor_origin, center, turntable):
    """The coverage of views of an object that is a point at its centre."""
    model = Model(Method.REFINED, center[None], None, np.empty((0, 3)))
    return measure_coverage(T_0, sensor_origin, model, turntable, HOW)


def arcs(coverage):
    return sorted((round(gap.start_deg), round(gap.end_deg)) for gap in coverage.gaps)


@given(SEEDS, st.integers(3, 12))
def test_gaps_and_what_is_covered_make_up_the_circle(seed, views):
    azimuths = dict(enumerate(np.random.default_rng(seed).uniform(0, 360, views)))
    gaps = find_gaps(azimuths, HOW.widest_deg)
    widths = [gap.end_deg - gap.start_deg for gap in gaps]
    assert widths == sorted(widths, reverse=True)
    assert all(width > HOW.widest_deg for width in widths)
    assert sum(gap.end_deg - gap.start_deg for gap in find_gaps(azimuths, -1.0)) == pytest.approx(360)
    for gap in gaps:
        width = gap.end_deg - gap.start_deg
        assert not [a for a in azimuths.values() if 1e-9 < (a - gap.start_deg) % 360 < width - 1e-9]
        assert azimuths[gap.after] == gap.start_deg
        assert azimuths[gap.before] == pytest.approx(gap.end_deg % 360)


@given(SEEDS)
def test_the_start_of_the_circle_changes_no_gap(seed):
    rng = np.random.default_rng(seed)
    azimuths, turn = dict(enumerate(rng.uniform(0, 360, 6))), rng.uniform(0, 360)
    turned = {view: (azimuth + turn) % 360 for view, azimuth in azimuths.items()}
    pairs = [{(gap.after, gap.before) for gap in find_gaps(a, HOW.widest_deg)} for a in (azimuths, turned)]
    assert pairs[0] == pairs[1]


def test_views_from_one_place_leave_all_the_rest():
    (gap,) = find_gaps({3: 10.0, 5: 10.0, 8: 10.0}, HOW.widest_deg)
    assert (gap.start_deg, gap.end_deg, gap.before) == (10, 370, 3)


@given(SEEDS, st.floats(-10, 70))
def test_missing_views_of_a_circle_are_found_whatever_the_elevation(seed, elevation_deg):
    azimuths = [a for a in range(0, 360, 20) if not 200 < a < 260]
    T_0, center = in_first_frame([look(a, elevation_deg) for a in azimuths])
    coverage = measure(T_0, CAMERA, center, None)
    assert arcs(coverage) == [(200, 260)]
    assert coverage.widest_deg == pytest.approx(60)
    assert [coverage.azimuths_deg[i] for i in range(5)] == pytest.approx([0, 20, 40, 60, 80])
    turntable = fit_turntable(T_0, TurntableSettings())
    assert arcs(measure(T_0, CAMERA, center + 0.1, turntable)) == [(200, 260)]


def test_a_camera_that_goes_clockwise_leaves_the_same_side_uncovered():
    T_0, center = in_first_frame([look(-a) for a in range(0, 300, 20)])  # the last one is at 80
    turntable = fit_turntable(T_0, TurntableSettings())
    assert turntable.axis[1] > 0  # the axis points down
    for given_turntable in (turntable, None):
        assert arcs(measure(T_0, CAMERA, center, given_turntable)) == [(0, 80)]


@given(SEEDS)
def test_cameras_at_any_elevation_agree_on_up(seed):
    rng = np.random.default_rng(seed)
    azimuths = np.cumsum(rng.uniform(15, 40, 8))
    T_object = [
        look(a, e, d) for a, e, d in zip(azimuths, rng.uniform(-20, 60, 8), rng.uniform(0.5, 2, 8), strict=True)
    ]
    T_0, _ = in_first_frame(T_object)
    assert np.allclose(find_up(T_0, HOW.min_views), poses.invert(T_object[0])[:3, 2], atol=1e-9)


def test_a_circle_has_no_gap_and_where_sensors_stand_matters_little():
    T_0, center = in_first_frame([look(a) for a in range(0, 360, 40)])
    for sensor in (CAMERA, (0.0, 0.0, -50.0), None):
        coverage = measure(T_0, sensor, center, None)
        assert coverage.gaps == ()
        assert coverage.azimuths_deg[3] == pytest.approx(120)
    assert np.allclose(coverage.toward(np.array([90.0]))[0], np.cross(coverage.up, coverage.forward))


def test_a_view_from_above_covers_no_azimuth():
    T_0, center = in_first_frame([look(0), look(60), look(120), look(240, 80)])
    assert arcs(measure(T_0, CAMERA, center, None)) == [(0, 60), (60, 120), (120, 360)]


@pytest.mark.parametrize("views", [1, 2])
def test_few_views_tell_nothing(views):
    T_0, center = in_first_frame([look(20 * i) for i in range(views)])
    assert measure(T_0, CAMERA, center, None) is None


@given(SEEDS)
def test_views_from_one_side_that_share_no_up_tell_nothing(seed):
    rng = np.random.default_rng(seed)
    held_anyhow = {i: random_pose(rng) for i in range(20)}
    one_side = {i: look(a) for i, a in enumerate(rng.uniform(0, 20, 8))}  # no telling roll
    assert find_up(held_anyhow, HOW.min_views) is None
    assert find_up(one_side, HOW.min_views) is None
