"""What geometry alone can tell of a pose, and what it must say it cannot."""

import numpy as np
import pytest

from processing.reconstruction.judgement import JudgementSettings, observability
from tests.geometry import blob

LEAST = JudgementSettings().min_observability


def noisy(rng, normals, sigma=0.05):
    """Unit normals off by some three degrees, as estimates from noisy points are."""
    normals = normals + rng.normal(scale=sigma, size=normals.shape)
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def sphere(rng, n):
    normals = rng.normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return 0.1 * normals, normals


def cylinder(rng, n):
    angle = rng.random(n) * np.pi
    normals = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])
    return 0.05 * normals + [0, 0, 1] * rng.random((n, 1)) * 0.2, normals


def plane(rng, n):
    return np.column_stack([rng.random((n, 2)), np.zeros(n)]), np.tile([0.0, 0, 1], (n, 1))


@pytest.mark.parametrize("shape", [sphere, cylinder, plane])
def test_surfaces_that_slide_are_not_observable_however_noisy(shape):
    rng = np.random.default_rng(0)
    points, normals = shape(rng, 8000)
    assert observability(points, noisy(rng, normals), noisy(rng, normals)) < LEAST
    # One view's normals alone would take their noise for relief.
    one = noisy(rng, normals)
    assert observability(points, one, one) > observability(points, noisy(rng, normals), noisy(rng, normals))


def test_a_key_makes_a_cylinder_observable():
    rng = np.random.default_rng(0)
    points, normals = cylinder(rng, 8000)
    keyed = np.abs(points[:, 0]) < 0.01  # a rib along the cylinder, its flank facing round
    normals[keyed] = [1.0, 0, 0]
    tilted = rng.random(8000) < 0.05  # and a shoulder, facing along
    normals[tilted] = [0, 0, 1.0]
    assert observability(points, noisy(rng, normals), noisy(rng, normals)) > LEAST


def test_observability_knows_no_scale_and_no_frame():
    rng = np.random.default_rng(0)
    points, _ = blob(rng, 4000)
    R, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    R *= np.sign(np.linalg.det(R))
    facing = rng.normal(size=points.shape)
    facing /= np.linalg.norm(facing, axis=1, keepdims=True)
    before = observability(points, facing, facing)
    after = observability(1000 * points @ R.T + 7, facing @ R.T, facing @ R.T)
    assert before == pytest.approx(after, rel=1e-9)
