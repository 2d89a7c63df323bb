import numpy as np
import pytest

from orbitscan.recorder import objects
from orbitscan.recorder.objects import cap
from orbitscan.recorder.objects.cap.crown import Crown, Dent
from orbitscan.recorder.objects.cap.parts import brim, shell
from tests.recorder.test_objects import assert_closed_and_outward

SEEDS = range(12)
CROWN = Crown(0.10, 0.08, 0.11, 0.65, 0.02)


def instances(style):
    """Meshes of a style, before they are placed."""
    return [style(np.random.default_rng(seed)) for seed in SEEDS]


def extents(style):
    return np.array([np.ptp(mesh.vertices, axis=0) for mesh in instances(style)])


@pytest.mark.parametrize("style", cap.STYLES)
def test_every_style_is_a_closed_thin_shell_of_a_heads_size(style):
    for mesh in instances(style):
        assert_closed_and_outward(mesh)
        length, width, height = np.ptp(mesh.vertices, axis=0)
        assert 0.20 < length < 0.30
        assert 0.12 < width < 0.20
        assert 0.04 < height < 0.17
        assert mesh.volume < 0.10 * length * width * height


def test_the_first_style_is_the_cap_of_earlier_recordings():
    mesh = objects.build("cap")
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [0.2589315, 0.15941788, 0.11377543], atol=1e-8)
    for instance in range(1, 25, len(cap.STYLES)):
        x, _, z = objects.build("cap", instance).vertices.T
        crown = x[z > 0.9 * z.max()].mean()
        assert x.max() - crown > 1.4 * (crown - x.min())
        assert z[x > x.max() - 0.02].max() < 0.5 * z.max()


def test_floppy_crowns_are_lower_and_truckers_higher():
    floppy, usual, trucker = (extents(style)[:, 2] for style in (cap.floppy, cap.build, cap.trucker))
    assert np.median(floppy) < 0.85 * np.median(usual)
    assert np.median(trucker) > 1.1 * np.median(usual)


def test_a_short_visor_makes_a_short_cap():
    assert np.median(extents(cap.short_visor)[:, 0]) < np.median(extents(cap.build)[:, 0]) - 0.015


def test_a_brim_is_flat_or_bent():
    flat = Crown(0.10, 0.08, 0.11, 0.65, 0.0)
    assert np.ptp(brim(flat, 0.07).vertices[:, 2]) < 0.0085
    curled = brim(CROWN, 0.07, curl=0.03)
    assert_closed_and_outward(curled)
    _, y, z = curled.vertices.T
    sides, middle = z[np.abs(y) > 0.06].min(), z[np.abs(y) < 0.01].min()
    assert middle - sides > 0.04


def test_a_brim_rises_or_falls_towards_its_front():
    for rise in (-0.02, 0.02):
        flat, tilted = (brim(CROWN, 0.07, amount).vertices for amount in (0.0, rise))
        front = flat[:, 0].argmax()
        assert tilted[front, 2] - flat[front, 2] == pytest.approx(rise, abs=0.002)
        np.testing.assert_allclose(tilted[:, :2], flat[:, :2])


@pytest.mark.parametrize("style", [cap.flat_brim, cap.floppy, cap.worn, cap.short_visor, cap.trucker])
def test_a_cap_rests_on_its_front_and_its_back(style):
    for mesh in instances(style):
        x, _, z = mesh.vertices.T
        ahead = x > x.min() + 0.42 * np.ptp(x)
        assert z[ahead].min() == pytest.approx(z[~ahead].min(), abs=0.004)


def test_a_dent_moves_its_center_and_leaves_far_points():
    dent = Dent(np.array([0.1, 0, 0.05]), np.array([-0.02, 0, 0]), 0.02)
    pressed = dent.press(np.array([[0.1, 0, 0.05], [-0.1, 0, 0.05]]))
    np.testing.assert_allclose(pressed, [[0.08, 0, 0.05], [-0.1, 0, 0.05]], atol=1e-9)


def test_dents_take_room_from_a_crown_but_leave_its_shell_whole():
    for seed in SEEDS:
        dented = CROWN.dented(np.random.default_rng(seed), 5, (0.01, 0.02))
        angle, share = np.meshgrid(np.linspace(0, 2 * np.pi, 60), np.linspace(0, 1, 30))
        moved = np.linalg.norm(dented.at(angle, share) - CROWN.at(angle, share), axis=-1)
        assert 0.008 < moved.max() < 0.1
        inside, outside = dented.at(angle, share, -0.0025), dented.at(angle, share)
        assert np.linalg.norm(outside - inside, axis=-1)[share < 0.95].min() > 0.0003
        assert_closed_and_outward(shell(dented, (1, 2, 3), (4, 5, 6)))
