import numpy as np
import pytest
from scipy.spatial import ConvexHull

from orbitscan.recorder.objects import bell_pepper
from orbitscan.recorder.objects.mesh import Mesh
from tests.recorder.test_objects import assert_closed_and_outward

BODY = (
    bell_pepper.LEVELS - 2
) * bell_pepper.SEGMENTS + 2  # vertices; the last two are the tip and the foot of the stem


@pytest.fixture(scope="module")
def peppers() -> list[Mesh]:
    return [bell_pepper.build(np.random.default_rng(seed)) for seed in range(60)]


def axes(peppers: list[Mesh]) -> np.ndarray:
    axes = np.array([mesh.vertices[BODY - 1] - mesh.vertices[BODY - 2] for mesh in peppers])
    return axes / np.linalg.norm(axes, axis=1, keepdims=True)


def test_peppers_are_closed_and_within_the_limits(peppers):
    for mesh in peppers:
        assert_closed_and_outward(mesh)
        assert 1000 < len(mesh.triangles) < 10_000
        assert mesh.colors.shape == mesh.vertices.shape


def test_peppers_are_from_blocky_to_long_as_those_of_a_shop(peppers):
    lengths, widths = [], []
    for mesh, axis in zip(peppers, axes(peppers), strict=True):
        body = mesh.vertices[:BODY]
        lengths.append(np.ptp(body @ axis))
        side = np.cross(axis, (0, 1, 0))
        widths.append(max(np.ptp(body @ side), np.ptp(body[:, 1])))
    assert 0.065 < min(lengths) < 0.085
    assert 0.105 < max(lengths) < 0.128
    proportions = np.divide(widths, lengths)
    assert proportions.min() < 0.68
    assert proportions.max() > 0.92


def test_half_of_them_lie_with_the_stem_to_the_front_and_the_others_stand(peppers):
    x, y, z = axes(peppers).T
    lying = x > z
    assert 0.3 < lying.mean() < 0.7
    assert (np.degrees(np.arctan2(x, z))[~lying] < 20).all()
    assert (np.degrees(np.arctan2(x, z))[lying] > 50).all()
    np.testing.assert_allclose(y, 0, atol=0.12)  # a bent pepper's tip is beside its axis
    for mesh in peppers:
        body = mesh.vertices[:BODY].mean(axis=0)
        stem = mesh.vertices[BODY:].mean(axis=0)
        assert stem[2] > body[2] or stem[0] > body[0]


def test_a_pepper_does_not_rest_on_a_point(peppers):
    for mesh in peppers:
        low = mesh.vertices[mesh.vertices[:, 2] < mesh.vertices[:, 2].min() + 0.0005]
        assert np.linalg.norm(np.ptp(low[:, :2], axis=0)) > 0.006


def test_the_top_is_sunken_about_a_stem_that_stands_out(peppers):
    for mesh, axis in zip(peppers, axes(peppers), strict=True):
        body, stem = mesh.vertices[:BODY], mesh.vertices[BODY:]
        equations = ConvexHull(body).equations
        assert -(equations[:, :3] @ body[-1] + equations[:, 3]).max() > 0.001
        assert np.ptp(stem @ axis) > 0.007
        assert stem.shape[0] > 100


def test_three_or_four_furrows_run_from_end_to_end():
    counts = []
    for seed in range(40):
        rings = bell_pepper._surface(np.random.default_rng(seed), 0.1, 0.7, 0.05)
        radii = np.hypot(*np.moveaxis(rings[..., :2], -1, 0))
        harmonics = np.abs(np.fft.rfft(radii[12:-12], axis=1))[:, 3:9].mean(axis=0)
        counts.append(3 + harmonics.argmax())
        for ring in (radii[12], radii[-12]):
            assert ring.min() < 0.93 * ring.max()
    assert set(counts) == {3, 4}
