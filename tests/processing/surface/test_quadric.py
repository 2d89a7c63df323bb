"""Quadrics fitted to noisy surfaces: where the surface truly is, which way it faces, and how noisy it was."""

import numba
import numpy as np
import pytest

from orbitscan.processing.surface.quadric import MIN_NEIGHBOURS, fit_quadrics
from orbitscan.recorder import poses
from tests.geometry import random_pose, sphere

NOISE = 0.0005


def tilted(rng, normals, sigma=0.1):
    """Unit normals off by some six degrees, as a first guess is."""
    normals = normals + rng.normal(scale=sigma, size=normals.shape)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def angles_deg(a, b):
    return np.degrees(np.arccos(np.clip(np.einsum("ni,ni->n", a, b), -1, 1)))


@pytest.fixture(scope="module")
def noisy_sphere():
    """A cloud on a sphere of 10 cm radius about (1, 2, 3), some of its points, and roughly their normals."""
    rng = np.random.default_rng(0)
    on, out = sphere(rng, 40_000)
    cloud = on + out * rng.normal(scale=NOISE, size=(len(on), 1)) + [1, 2, 3]
    return cloud, cloud[:800], tilted(rng, out[:800]), out[:800]


def test_a_plane_is_found_with_its_noise():
    rng = np.random.default_rng(0)
    cloud = np.column_stack([rng.random((20_000, 2)) * 0.2, rng.normal(scale=NOISE, size=20_000)])
    inner = cloud[(np.abs(cloud[:, :2] - 0.1) < 0.08).all(axis=1)][:500]
    points, normals, variances = fit_quadrics(inner, tilted(rng, np.tile([0.0, 0, 1], (500, 1))), cloud, 0.008)
    assert np.abs(points[:, 2]).std() < NOISE / 3
    assert np.median(angles_deg(normals, np.tile([0.0, 0, 1], (500, 1)))) < 2
    assert np.sqrt(variances.mean()) == pytest.approx(NOISE, rel=0.05)


def test_points_land_on_a_sphere_and_not_inside_it_as_on_a_plane(noisy_sphere):
    cloud, inner, rough, out = noisy_sphere
    radius = 0.02
    points, normals, _ = fit_quadrics(inner, rough, cloud, radius)
    off = np.linalg.norm(points - [1, 2, 3], axis=1) - 0.1
    planes = np.array([cloud[np.linalg.norm(cloud - p, axis=1) < radius].mean(axis=0) for p in inner[:50]])
    inside = np.linalg.norm(planes - [1, 2, 3], axis=1) - 0.1
    assert inside.mean() < -8e-4
    assert abs(off.mean()) < 1e-5
    assert off.std() < NOISE / 5
    assert np.median(angles_deg(normals, out)) < 1.5
    assert np.median(angles_deg(normals, out)) < np.median(angles_deg(rough, out)) / 4


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_the_variance_is_that_of_the_noise(factor):
    rng = np.random.default_rng(1)
    on, out = sphere(rng, 40_000)
    cloud = on + out * rng.normal(scale=factor * NOISE, size=(len(on), 1))
    _, _, variances = fit_quadrics(cloud[:400], out[:400], cloud, 0.01)
    assert np.sqrt(variances.mean()) == pytest.approx(factor * NOISE, rel=0.05)


def test_a_crease_has_more_variance_than_its_sides():
    rng = np.random.default_rng(2)
    x, y = rng.random((2, 20_000)) * 0.2 - 0.1
    cloud = np.column_stack([x, y, -np.abs(x)])
    normals = np.tile([0.0, 0, 1], (len(cloud), 1))
    _, _, variances = fit_quadrics(cloud, normals, cloud, 0.01)
    crease, sides = np.abs(x) < 0.001, (np.abs(x) > 0.02) & (np.abs(x) < 0.08)
    assert variances[crease].min() > 100 * variances[sides].max()


def test_few_neighbours_or_no_normal_are_nan():
    rng = np.random.default_rng(3)
    for count in (0, 1, MIN_NEIGHBOURS - 1, MIN_NEIGHBOURS):
        cloud = np.column_stack([rng.random((count, 2)) * 0.01, np.zeros(count)])
        point, up = np.array([[0.005, 0.005, 0]]), np.array([[0.0, 0, 1]])
        found, turned, variances = fit_quadrics(point, up, cloud, 0.02)
        assert np.isnan(variances).all() == (count < MIN_NEIGHBOURS)
        assert np.isfinite(found).all()
        assert np.isfinite(turned).all()
        assert np.isnan(fit_quadrics(point, np.full((1, 3), np.nan), cloud, 0.02)[2]).all()


def test_it_moves_with_the_surface(noisy_sphere):
    cloud, inner, rough, _ = noisy_sphere
    T = random_pose(np.random.default_rng(5))
    points, normals, variances = fit_quadrics(inner, rough, cloud, 0.01)
    turned = rough @ T[:3, :3].T
    moved = fit_quadrics(poses.transform(T, inner), turned, poses.transform(T, cloud), 0.01)
    # The tangents differ, and with them only how the small ridge acts.
    assert np.abs(moved[0] - poses.transform(T, points)).max() < 1e-7
    assert np.abs(moved[1] - normals @ T[:3, :3].T).max() < 1e-4
    assert np.allclose(moved[2], variances, rtol=1e-4)


def test_neither_its_inputs_nor_the_number_of_threads_show(noisy_sphere):
    cloud, inner, rough, _ = noisy_sphere
    before = inner.copy(), rough.copy()
    many = fit_quadrics(inner, rough, cloud, 0.01)
    assert (inner == before[0]).all()
    assert (rough == before[1]).all()
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        one = fit_quadrics(inner, rough, cloud, 0.01)
    finally:
        numba.set_num_threads(threads)
    assert [a.tobytes() for a in one] == [a.tobytes() for a in many]
