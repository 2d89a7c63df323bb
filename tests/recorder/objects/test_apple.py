import numpy as np
import pytest
from scipy.spatial import ConvexHull

from orbitscan.recorder.objects import apple
from orbitscan.recorder.objects.mesh import Mesh
from tests.recorder.test_objects import assert_closed_and_outward

BODY = (apple.LEVELS - 2) * apple.SEGMENTS + 2  # vertices; the last two are the calyx and the foot of the stem


@pytest.fixture(scope="module")
def apples() -> list[Mesh]:
    return [apple.build(np.random.default_rng(seed)) for seed in range(40)]


def bodies(apples: list[Mesh]) -> list[np.ndarray]:
    return [mesh.vertices[:BODY] for mesh in apples]


def axes(apples: list[Mesh]) -> np.ndarray:
    axes = np.array([body[-1] - body[-2] for body in bodies(apples)])
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


def depth(point: np.ndarray, body: np.ndarray) -> float:
    """How far the point is below the convex hull of the body [m]."""
    equations = ConvexHull(body).equations
    return -(equations[:, :3] @ point + equations[:, 3]).max()


def test_apples_are_closed_and_within_the_limits(apples):
    for mesh in apples:
        assert_closed_and_outward(mesh)
        assert 1000 < len(mesh.triangles) < 10_000
        assert mesh.colors.shape == mesh.vertices.shape


def test_apples_are_as_wide_as_those_of_a_shop(apples):
    for body in bodies(apples):
        assert 0.055 < np.ptp(body, axis=0).max() < 0.105
        assert np.ptp(body, axis=0).min() > 0.045


def test_stem_and_calyx_are_dented(apples):
    stems, calyxes = np.array([[depth(body[-1], body), depth(body[-2], body)] for body in bodies(apples)]).T
    assert stems.min() > 0.004
    assert stems.max() < 0.03
    assert calyxes.min() > 0.001
    assert stems.mean() > calyxes.mean()


def test_the_body_is_round_but_not_a_ball(apples):
    for body in bodies(apples):
        hull = ConvexHull(body)
        assert 0.90 < (36 * np.pi * hull.volume**2) ** (1 / 3) / hull.area < 0.998


def test_habits_reach_from_flat_to_tall(apples):
    proportions = []
    for body, axis in zip(bodies(apples), axes(apples), strict=True):
        along = body @ axis
        across = np.linalg.norm(body - body.mean(axis=0) - np.outer(along - along.mean(), axis), axis=1)
        proportions.append(np.ptp(along) / (2 * across.max()))
    assert min(proportions) < 0.78
    assert max(proportions) > 0.98


def test_some_have_a_stem_that_stands_in_the_dent(apples):
    stems = [mesh.vertices[BODY:] for mesh in apples if len(mesh.vertices) > BODY]
    assert 0.5 < len(stems) / len(apples) < 0.9
    for mesh in apples:
        stem = mesh.vertices[BODY:]
        if len(stem):
            assert np.linalg.norm(stem - mesh.vertices[BODY - 1], axis=1).min() < 0.005
            assert np.linalg.norm(stem - mesh.vertices[BODY - 1], axis=1).max() > 0.008


def test_most_stand_some_lean_and_some_lie_towards_the_front(apples):
    x, y, z = axes(apples).T
    np.testing.assert_allclose(y, 0, atol=0.15)  # a crooked apple's dents are beside its axis
    assert (x > -0.15).all()
    tilts = np.degrees(np.arctan2(x, z))
    assert np.mean(tilts < 25) > 0.4
    assert np.mean(tilts > 55) > 0.05


def test_the_foot_has_five_lobes_as_high_as_asked():
    for seed in range(20):
        ring = {
            lobes: np.linalg.norm(apple._surface(np.random.default_rng(seed), lobes), axis=-1)[10]
            for lobes in (0.0, 0.03, 0.06)
        }
        lobe = ring[0.06] - ring[0.0]
        harmonics = np.abs(np.fft.rfft(lobe))
        assert harmonics[1:].argmax() + 1 == 5
        np.testing.assert_allclose(lobe, 2 * (ring[0.03] - ring[0.0]), atol=1e-12)
        assert np.ptp(lobe) > 0.05
