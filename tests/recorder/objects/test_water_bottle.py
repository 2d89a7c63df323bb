from dataclasses import replace

import numpy as np
import pytest

from orbitscan.recorder.objects import build, water_bottle
from orbitscan.recorder.objects.bottle import Form, body
from orbitscan.recorder.objects.closure import carrying_loop, cup_lid, screw_cap, sports_cap, tether
from orbitscan.recorder.objects.vessel import superellipse
from tests.recorder.test_objects import assert_closed_and_outward

STEEL, RED = (188, 192, 196), (188, 58, 52)
PLAIN = Form(height=0.20, radius=0.035, neck=0.015, shoulder=0.04)


@pytest.mark.parametrize("style", water_bottle.STYLES)
def test_a_bottle_of_any_style_stands_upright_and_narrows_towards_its_mouth(style):
    for seed in range(6):
        mesh = style(np.random.default_rng(seed))
        assert_closed_and_outward(mesh)
        assert len(mesh.triangles) < 10_000
        x, _, z = mesh.vertices.T
        height = np.ptp(z)
        assert z.min() == pytest.approx(0, abs=1e-9)
        assert 0.145 < height < 0.335
        assert 1.4 < height / np.ptp(x) < 5
        assert x[z < 0.5 * height].max() > 0.95 * x[z > 0.9 * height].max()  # loops are along y


@pytest.mark.parametrize("style", water_bottle.STYLES)
def test_a_lid_hides_the_mouth_it_closes(style):
    for seed in range(12):
        mesh = style(np.random.default_rng(seed))
        axis = np.hypot(*mesh.vertices.T[:2]) < 1e-9
        heights = np.sort(mesh.vertices[axis, 2])
        if len(heights) > 2:  # there is a lid: its top is well above the neck's
            assert heights[-1] > heights[1] + 0.0015


def test_proportions_are_those_of_a_shop():
    sizes = np.array([np.ptp(build("water_bottle", instance).vertices, axis=0) for instance in range(1, 61)])
    slender = sizes[:, 2] / sizes[:, :2].max(axis=1)
    assert slender.min() < 2
    assert slender.max() > 3.8
    assert sizes[:, 2].min() < 0.165
    assert sizes[:, 2].max() > 0.30


@pytest.mark.parametrize("style", water_bottle.STYLES)
def test_only_the_round_styles_look_the_same_from_all_sides(style):
    turn = np.radians(360 / water_bottle.SEGMENTS)
    for seed in range(3):
        vertices = style(np.random.default_rng(seed)).vertices
        x, y, z = vertices.T
        turned = np.column_stack([x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn), z])
        same = {tuple(v) for v in (vertices * 1e8).round() + 0.0} == {tuple(v) for v in (turned * 1e8).round() + 0.0}
        assert same == (style in water_bottle.ROUND)


def test_a_body_has_its_forms_measures():
    mesh = body(PLAIN, (RED, STEEL))
    assert_closed_and_outward(mesh)
    radii, z = np.hypot(*mesh.vertices.T[:2]), mesh.vertices[:, 2]
    assert z.max() == pytest.approx(PLAIN.height + PLAIN.stem)
    assert radii.max() == pytest.approx(PLAIN.radius)
    assert radii[z > PLAIN.height + 1e-6].max() == pytest.approx(PLAIN.neck + 0.0015)
    assert (mesh.colors[z < PLAIN.height - 1e-3] == RED).all()
    assert mesh.volume == pytest.approx(np.pi * 0.035**2 * 0.185, rel=0.05)


def test_a_waist_and_ribs_go_as_deep_as_they_say():
    assert replace(PLAIN, waist=0.2, middle=0.5).wall[:, 0].min() == pytest.approx(0.8 * 0.035, rel=0.01)
    ribbed = replace(PLAIN, ribs=4, depth=0.002, grooved=(0.3, 0.7)).wall
    assert np.isclose(ribbed[:, 0], 0.033).sum() == 4
    assert (np.diff(ribbed[:, 1]) > 0).all()
    assert replace(PLAIN, taper=0.8).wall[0, 0] == pytest.approx(0.8 * 0.035, rel=0.02)


def test_an_open_bottle_is_hollow():
    mesh = body(replace(PLAIN, open=True), (RED, STEEL))
    assert_closed_and_outward(mesh)
    assert mesh.volume < 0.35 * body(PLAIN, (RED, STEEL)).volume
    assert mesh.vertices[np.hypot(*mesh.vertices.T[:2]) < 1e-9, 2].max() < 0.01


def test_a_square_body_has_a_round_neck():
    x, y, z = body(PLAIN, (RED, STEEL), superellipse(5)).vertices.T
    radii = np.hypot(x, y)
    assert radii[np.abs(z - 0.08) < 0.02].max() > 1.2 * 0.035
    neck = radii[z == z.max()]
    assert np.ptp(neck[neck > 0]) < 1e-12


@pytest.mark.parametrize(
    ("mesh", "size"),
    [
        (screw_cap(0.02, 0.015), (0.04, 0.04, 0.015)),
        (sports_cap(0.03, 0.02, 0.008, 0.025), (0.06, 0.06, 0.045)),
        (cup_lid(0.035, 0.06, 0.9), (0.07, 0.07, 0.06)),
    ],
)
def test_lids_have_their_sizes_and_stand_on_zero(mesh, size):
    assert_closed_and_outward(mesh)
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), size, rtol=1e-3)
    assert mesh.vertices[:, 2].min() == 0


def test_loops_bow_as_far_as_they_say():
    loop = carrying_loop(0.03, 0.025, 0.012)
    strap = tether((0.02, 0.01), (0.015, -0.01), 0.02, 0.010)
    for mesh in (loop, strap):
        assert_closed_and_outward(mesh)
    x, y, z = loop.vertices.T
    assert np.ptp(x) == pytest.approx(0.012, rel=0.05)
    assert np.ptp(y) == pytest.approx(0.06 + 0.005, rel=0.05)
    assert z.max() == pytest.approx(0.025 - 0.002 + 0.0025, abs=3e-4)
    assert 0.035 < strap.vertices[:, 1].max() < 0.041
