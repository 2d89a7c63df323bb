"""A view prepared: its scale, its working points, and surfels that are nearer to the surface than any point."""

from dataclasses import replace

import numpy as np
import pytest

from orbitscan.processing.surface.preparation import SurfaceSettings, choose_scale, prepare
from orbitscan.recorder.session import SessionInfo, View, in_memory
from tests.geometry import scan, sphere

HOW = SurfaceSettings()
NOISE = 0.0008


@pytest.fixture(scope="module")
def ball():
    """A session of a sphere of 10 cm radius, the scale, and the first view's surface."""
    session = scan(n_views=3, surface=sphere, noise=NOISE)
    scale = choose_scale(session.views(), HOW)
    return session, scale, prepare(session.load(0), scale, session.info.sensor_origin, HOW)


def distance(session, points):
    """From the sphere's surface [m]."""
    middle = np.linalg.inv(session.truth()[0])[:3, 3]
    return np.linalg.norm(points - middle, axis=1) - 0.1


def test_the_scale_is_that_of_the_scan(ball):
    session, scale, _ = ball
    assert scale.working >= max(HOW.noise_factor * scale.noise, HOW.diameter_share * scale.diameter)
    assert scale.working < scale.patch  # the resolution is no larger than the reach of a neighbourhood
    assert 0.18 < scale.diameter < 0.3
    assert 0.4 * NOISE < scale.noise < 1.2 * NOISE
    larger = [replace(v, points=10 * v.points) for v in session.views()]
    tenfold = choose_scale(in_memory(session.info, larger).views(), HOW)
    assert tenfold.working == pytest.approx(10 * scale.working, rel=1e-3)


def test_surfels_are_nearer_to_the_surface_than_points(ball):
    session, _, surface = ball
    off = distance(session, surface.surfels.points)
    assert off.std() < 0.85 * distance(session, surface.points).std()
    assert abs(off.mean()) < NOISE / 10
    middle = np.linalg.inv(session.truth()[0])[:3, 3]
    out = (surface.surfels.points - middle) / np.linalg.norm(surface.surfels.points - middle, axis=1)[:, None]
    assert np.median(np.einsum("ni,ni->n", out, surface.surfels.normals)) > np.cos(np.radians(12))
    assert len(surface.surfels) > 0.9 * len(surface.working)
    assert np.isfinite(surface.surfels.variances).all()


def test_normals_face_the_sensor_or_away_from_the_middle(ball):
    session, scale, surface = ball
    to_sensor = surface.sensor_origin - surface.surfels.points
    facing = np.einsum("ni,ni->n", surface.sensor_origin - surface.working, surface.normals)
    assert (facing[np.isfinite(facing)] > 0).all()
    assert (np.einsum("ni,ni->n", to_sensor, surface.surfels.normals) > 0).mean() > 0.98  # noise turns those edge-on
    blind = prepare(session.load(0), scale, None, HOW)
    assert blind.sensor_origin is None
    outward = blind.surfels.points - blind.surfels.points.mean(axis=0)
    assert (np.einsum("ni,ni->n", outward, blind.surfels.normals) > 0).mean() > 0.9


def test_too_few_points_are_not_enough(ball):
    session, scale, _ = ball
    view = session.load(0)
    for points in (view.points[:0], view.points[:3], np.full((500, 3), np.nan, np.float32)):
        surface = prepare(replace(view, points=points), scale, (0, 0, 0), HOW)
        assert not surface.enough
        assert len(surface.surfels) == 0
    assert not prepare(view, None, (0, 0, 0), HOW).enough


def test_no_view_with_points_has_no_scale():
    views = [View(i, str(i), i, np.zeros((3, 3), np.float32)) for i in range(2)]
    assert choose_scale(in_memory(SessionInfo("none", 2), views).views(), HOW) is None
    one_place = [View(i, str(i), i, np.ones((500, 3), np.float32)) for i in range(2)]
    assert choose_scale(in_memory(SessionInfo("one place", 2), one_place).views(), HOW) is None


def test_an_empty_view_among_the_first_does_not_spoil_the_scale(ball):
    session, scale, _ = ball
    views = list(session.views())
    views[0] = replace(views[0], points=views[0].points[:4])
    found = choose_scale(in_memory(session.info, views).views(), HOW)
    assert found.working == pytest.approx(scale.working, rel=0.05)
