"""What each category is told by: a mug's handle, a bowl's hollow, a cap's brim, the jaws of pliers."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree

from orbitscan.recorder.simulation.objects import bowl, cap, cell_phone, notebook, pliers, vessel, water_bottle
from orbitscan.recorder.simulation.objects.cell_phone.folding import flip_open, flip_shut
from orbitscan.recorder.simulation.objects.notebook.opened import ajar, open_coiled, open_flat
from orbitscan.recorder.simulation.objects.pliers.adjustable import tongue_and_groove
from orbitscan.recorder.simulation.objects.pliers.fixed import mini, needle_nose
from tests.recorder.simulation.objects.shapes import crossings, dents, extents, instances, largest_part, of_style

ROUND_CELLS = {  # the largest diameter and length of IEC 60086-2 [m]
    "AAA": (0.0105, 0.0445),
    "AA": (0.0145, 0.0505),
    "C": (0.0262, 0.0500),
    "D": (0.0342, 0.0615),
}
BLOCKS = {  # metres: the least and the largest of the sides, from the shortest to the longest
    "9 V": ((0.0155, 0.0245, 0.0460), (0.0175, 0.0265, 0.0493)),
    "4.5 V": ((0.0199, 0.0599, 0.0610), (0.0221, 0.0621, 0.0770)),
    "lantern": ((0.0630, 0.0640, 0.0960), (0.0671, 0.0671, 0.1170)),
}
PLACES = (0.2, 0.4, 0.6, 0.8)  # shares of the way out from a gutter


def test_a_mug_is_hollow_down_to_its_floor():
    for mesh in instances("coffee_mug"):
        low, (radius, _, height) = mesh.bounds
        below, floor = crossings(mesh, "z", 0, low[1] + radius)
        assert below + 0.0025 < floor < 0.2 * height
        assert mesh.volume < 0.45 * np.pi * radius**2 * height
        for level in (0.5, 0.75, 0.95):
            left, right = crossings(mesh, "x", low[1] + radius, level * height)[1:3]
            assert right - left > 0.6 * 2 * radius


def test_a_mugs_handle_is_a_bow_to_the_right_of_the_front_with_room_for_a_finger():
    for mesh in instances("coffee_mug"):
        low, (radius, end, height) = mesh.bounds
        body = low[1] + 2 * radius
        reach = end - body
        beyond = mesh.vertices[mesh.vertices[:, 1] > body + 0.004]
        assert reach > 0.010
        assert np.abs(beyond[:, 0]).max() < 0.014
        assert beyond[:, 2].min() > 0.02 * height
        assert beyond[:, 2].max() < 1.02 * height
        levels = np.arange(0, height, 0.002)
        held = [z for z in levels if len(crossings(mesh, "x", body + 0.3 * reach, z))]
        assert np.diff(held).max() > 0.02


def test_mugs_are_from_tea_cups_to_lattes():
    across, along, height = extents(instances("coffee_mug", 36)).T
    assert (height / across).min() < 0.75
    assert (height / across).max() > 1.35
    assert height.max() > 1.8 * height.min()
    assert np.ptp(along - across) > 0.02


def test_a_bowl_is_hollow_and_has_no_handle():
    for mesh in instances("bowl"):
        x, y, height = mesh.bounds[1]
        below, floor = crossings(mesh, "z", 0, 0)
        assert below + 0.0015 < floor < 0.4 * height
        assert mesh.volume < 0.4 * np.pi * x**2 * height
        for level in (0.6, 0.75, 0.95):
            outer, inner = crossings(mesh, "x", 0, level * height)[[0, 1]]
            assert 0 < inner - outer < 0.2 * x
            assert len(crossings(mesh, "x", 0, level * height)) == 4
        assert x == pytest.approx(y, rel=0.16)
        assert 0.2 < height / (2 * x) < 0.75


def test_bowls_are_from_almost_plates_to_deep_and_from_dips_to_salad_bowls():
    across, _, height = extents(instances("bowl", 36)).T
    assert (height / across).min() < 0.27
    assert (height / across).max() > 0.55
    assert across.max() > 2 * across.min()


@pytest.mark.parametrize("module", [bowl, water_bottle])
def test_a_turn_by_one_segment_maps_the_round_styles_onto_themselves_and_no_others(module):
    assert vessel.SEGMENTS >= 96  # so that the facets are no features
    assert len(module.ROUND) >= 9  # the benchmark registers the first instances as surfaces of revolution
    assert module.STYLES[: len(module.ROUND)] == module.ROUND
    for style in module.STYLES:
        (mesh,) = of_style(module, style, 1)
        distance, same = cKDTree(mesh.vertices).query(mesh.turned("z", 360 / vessel.SEGMENTS).vertices)
        assert (distance.max() < 1e-12) == (style in module.ROUND)
        if style in module.ROUND:
            np.testing.assert_array_equal(mesh.colors[same], mesh.colors)


def test_a_bottle_stands_upright_and_has_a_neck():
    for mesh in instances("water_bottle", 24):
        x, y, height = mesh.bounds[1]
        assert 1.4 < height / (2 * x) < 5
        assert y > 0.9 * x  # loops are to the sides
        width = [np.ptp(crossings(mesh, "x", 0, level * height)) for level in np.linspace(0.05, 0.95, 13)]
        assert min(width[7:]) < 0.95 * max(width[:7])


def test_a_bottle_is_closed_by_a_lid_or_hollow():
    tops = np.array([crossings(m, "z", 0, 0)[-1] / m.bounds[1][2] for m in instances("water_bottle", 24)])
    assert ((tops > 0.85) | (tops < 0.75)).all()
    assert (tops > 0.85).sum() > 12
    assert tops.min() < 0.1


def test_bottles_are_from_stout_to_slender():
    sides = extents(instances("water_bottle", 36))
    slender = sides[:, 2] / sides[:, :2].max(axis=1)
    assert slender.min() < 2.4
    assert slender.max() > 3.8
    assert sides[:, 2].max() > 1.7 * sides[:, 2].min()


def test_a_cap_is_a_thin_shell_that_is_hollow_below():
    for mesh in instances("cap"):
        x, _, z = mesh.vertices.T
        inside, *_, top = crossings(mesh, "z", x[z > 0.9 * z.max()].mean(), 0)
        assert inside > 0.8 * z.max()
        assert top - inside < 0.2 * z.max()
        assert mesh.volume < 0.10 * np.prod(extents([mesh]))


def test_a_caps_brim_reaches_forward_wide_thin_and_below_the_crown():
    for mesh in instances("cap"):
        x, y, z = mesh.vertices.T
        front = x > x.max() - 0.03
        assert z[front].max() < 0.9 * z.max()
        assert np.ptp(y[front]) > 0.08
        assert np.ptp(crossings(mesh, "z", x.max() - 0.03, 0)) < 0.006
        assert np.ptp(y[x < x.min() + 0.005]) < 0.08  # there is none behind


@pytest.mark.parametrize("style", [style for style in cap.STYLES if style is not cap.build])
def test_a_cap_rests_on_its_front_and_its_back(style):
    for mesh in of_style(cap, style, 2):
        x, _, z = mesh.vertices.T
        ahead = x > x.min() + 0.42 * np.ptp(x)
        assert z[ahead].min() == pytest.approx(z[~ahead].min(), abs=0.004)


def test_floppy_caps_are_lower_truckers_higher_and_short_visors_shorter():
    usual, floppy, trucker, short = (
        np.median(extents(of_style(cap, style, 8)), axis=0)
        for style in (cap.build, cap.floppy, cap.trucker, cap.short_visor)
    )
    assert floppy[2] < 0.85 * usual[2]
    assert trucker[2] > 1.1 * usual[2]
    assert short[0] < usual[0] - 0.015


def test_pliers_lie_flat_and_have_a_handle_to_each_side():
    for mesh in instances("pliers", 14):
        low, (front, _, height) = mesh.bounds
        length = front - low[0]
        assert height < 0.2 * length
        handles = crossings(mesh, "y", low[0] + 0.33 * length, height / 2)
        right, left = handles[handles < 0], handles[handles > 0]
        assert left.min() - right.max() > 0.015
        assert np.ptp(left) < 0.035
        assert np.ptp(right) < 0.035


def test_the_jaws_of_pliers_are_shut_or_open():
    gaps = []
    for mesh in instances("pliers", 14):
        x, y, _ = mesh.vertices.T
        gaps.append(np.diff(np.sort(y[x > x.max() - 0.004])).max())
    assert min(gaps) < 0.002
    assert max(gaps) > 0.015


def test_needle_noses_are_long_and_mini_pliers_short():
    assert extents(of_style(pliers, needle_nose, 5))[:, 0].min() > 0.15
    assert extents(of_style(pliers, mini, 5))[:, 0].max() < 0.14


def test_the_jaws_of_tongue_and_groove_pliers_stand_at_an_angle():
    for mesh in of_style(pliers, tongue_and_groove, 5):
        x, y, _ = mesh.vertices.T
        ends = [y[end].mean() for end in (x > x.max() - 0.02, x < x.min() + 0.02)]
        assert ends[0] - ends[1] > 0.01


def test_a_phone_is_slender_and_fits_a_hand():
    for mesh in instances("cell_phone", 14):
        principal = np.linalg.svd(mesh.vertices - mesh.vertices.mean(axis=0), full_matrices=False)[2]
        length, width, thickness = np.ptp(mesh.vertices @ principal.T, axis=0)
        assert 0.085 < length < 0.21
        assert 0.035 < width < 0.105
        assert thickness < 0.04


def test_most_phones_lie_flat_and_some_lean():
    heights = extents(instances("cell_phone", 42))[:, 2]
    assert 0.6 < np.mean(heights < 0.05) < 0.95
    assert np.sum(heights > 0.06) >= 2


def test_an_open_flip_phone_is_nearly_two_shut_ones_long():
    longest = [extents(of_style(cell_phone, style, 5)).max(axis=1) for style in (flip_open, flip_shut)]
    assert longest[0].min() > 0.14
    assert longest[1].max() < 0.14


@pytest.mark.parametrize("style", [s for s in notebook.STYLES if s not in (ajar, open_coiled, open_flat)])
def test_a_shut_notebook_is_flat_and_of_a_page_in_size(style):
    x, y, z = extents(of_style(notebook, style, 4)).T
    assert (np.maximum(x, y) < 0.32).all()
    assert (np.minimum(x, y) > 0.085).all()
    assert (z < 0.35 * np.maximum(x, y)).all()


def test_an_open_notebook_is_two_pages_wide_and_lower_at_its_gutter():
    for mesh in of_style(notebook, open_flat, 4):
        x, y, height = mesh.bounds[1]
        assert y > 1.15 * x
        gutter = crossings(mesh, "z", 0, 0)[-1]
        pages = np.array([crossings(mesh, "z", 0, side * share * y)[-1] for side in (-1, 1) for share in PLACES])
        assert (gutter < 0.7 * pages.reshape(2, -1).max(axis=1)).all()
        assert gutter < 0.6 * height


def test_notebooks_come_thick_and_thin_from_pocket_to_a4():
    sizes = extents(instances("notebook", 28))
    longest = sizes[:, :2].max(axis=1)
    assert longest.min() < 0.16
    assert longest.max() > 0.29
    assert sizes[:, 2].min() < 0.018
    assert sizes[:, 2].max() > 0.03


def test_an_apple_is_round_and_dented_at_two_opposite_places():
    for body, _, depth in fruits("apple"):
        hull, toward = ConvexHull(body), body - body.mean(axis=0)
        assert 0.90 < (36 * np.pi * hull.volume**2) ** (1 / 3) / hull.area < 0.998
        assert 0.004 < depth.max() < 0.03
        assert depth[toward @ toward[depth.argmax()] < 0].max() > 0.001


def test_most_apples_have_a_stem_in_the_dent_above_or_before():
    stemmed = [fruit for fruit in fruits("apple") if len(fruit[1])]
    assert 0.5 < len(stemmed) / len(fruits("apple")) < 0.9
    for body, stem, depth in stemmed:
        assert cKDTree(body[depth > 0.004]).query(stem)[0].min() < 0.005
        assert np.linalg.norm(np.ptp(stem, axis=0)) > 0.008
        assert (stem.mean(axis=0) - body.mean(axis=0))[[0, 2]].max() > 0.02


def test_apples_are_from_flat_to_tall():
    height = extents(instances("apple"))[:, 2] / extents(instances("apple"))[:, :2].max(axis=1)
    assert height.min() < 0.8
    assert height.max() > 0.95


@pytest.mark.parametrize(("name", "most"), [("apple", -0.006), ("bell_pepper", 0.002)])
def test_a_fruits_center_of_mass_is_above_where_it_rests(name, most):
    for mesh in instances(name):
        a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
        volumes = np.einsum("ti,ti->t", a, np.cross(b, c))
        center = volumes @ (a + b + c)[:, :2] / (4 * volumes.sum())
        sides = ConvexHull(mesh.vertices[mesh.vertices[:, 2] < 0.0015, :2]).equations
        assert (sides[:, :2] @ center + sides[:, 2]).max() < most


def test_a_pepper_has_a_sunken_top_and_a_stem_out_of_it_above_or_before():
    lying = []
    for body, stem, depth in fruits("bell_pepper"):
        outward = stem.mean(axis=0) - body.mean(axis=0)
        assert np.linalg.norm(np.ptp(stem, axis=0)) > 0.007
        assert depth[cKDTree(stem).query(body)[0].argmin()] > 0.001
        assert abs(outward[1]) < 0.2 * np.linalg.norm(outward)
        assert outward[[0, 2]].max() > 0.02
        lying.append(outward[0] > outward[2])
    assert 0.2 < np.mean(lying) < 0.8


def test_a_standing_pepper_has_three_or_four_furrows():
    counts = set()
    for mesh in instances("bell_pepper", 24):
        of_body = largest_part(mesh)
        x, y, z = mesh.vertices[of_body].T
        if mesh.vertices[~of_body, 2].min() < 0.6 * z.max():
            continue
        belly = (z > 0.35 * z.max()) & (z < 0.75 * z.max())
        place = (x + 1j * y)[belly]
        place -= place.mean()
        around = np.exp(1j * np.outer(np.angle(place), range(1, 9)))
        waves = np.column_stack([np.ones(len(place)), around.real, around.imag])
        cosines, sines = np.linalg.lstsq(waves, np.abs(place))[0][1:].reshape(2, 8)
        counts.add(3 + int(np.hypot(cosines, sines)[2:].argmax()))
    assert counts == {3, 4}


def test_a_battery_is_of_a_standard_size_and_every_size_is_seen():
    seen = {_format(sides) for sides in extents(instances("dry_battery", 60))}
    assert seen == {*ROUND_CELLS, *BLOCKS, "pack"}


def test_a_round_cell_bears_a_nub_on_top_or_in_front():
    standing = []
    for mesh in instances("dry_battery", 60):
        sides = extents([mesh])[0]
        if _format(sides) not in ROUND_CELLS:
            continue
        axis = sides.argmax()
        along, across = mesh.vertices[:, axis], np.delete(mesh.vertices, axis, axis=1)
        plus, minus = (
            np.ptp(across[at], axis=0).max() for at in (along > along.max() - 0.0005, along < along.min() + 0.0005)
        )
        assert axis in (0, 2)
        assert plus < 0.5 * sides.min()
        assert minus > 0.8 * sides.min()
        standing.append(axis == 2)
    assert 0.1 < np.mean(standing) < 0.9


def test_a_nine_volt_block_bears_two_snaps_half_an_inch_apart():
    blocks = [mesh for mesh in instances("dry_battery", 60) if _format(extents([mesh])[0]) == "9 V"]
    assert blocks
    for mesh in blocks:
        _, across, axis = extents([mesh])[0].argsort()
        middle = np.mean(mesh.bounds, axis=0)
        ends = mesh.vertices[mesh.vertices[:, axis] > mesh.bounds[1][axis] - 0.001, across] - middle[across]
        left, right = ends[ends < 0], ends[ends > 0]
        assert (right.min() + right.max() - left.min() - left.max()) / 2 == pytest.approx(0.0127, abs=1e-4)
        assert max(np.ptp(left), np.ptp(right)) > 1.3 * min(np.ptp(left), np.ptp(right))  # the minus snap is flared


@pytest.mark.parametrize("name", ["comb", "fork", "keyboard", "plate", "scissors", "spoon"])
def test_flat_things_lie_flat(name):
    sides = extents(instances(name))
    assert (sides[:, 2] < 0.2 * sides[:, :2].max(axis=1)).all()


@pytest.mark.parametrize("name", ["desk_lamp", "wine_glass", "ball"])
def test_tall_things_stand(name):
    sides = extents(instances(name))
    assert (sides[:, 2] > 0.7 * sides[:, :2].max(axis=1)).all()


def test_a_wine_glass_is_open_at_its_top():
    for mesh in instances("wine_glass"):
        assert crossings(mesh, "z", 0, 0)[-1] < 0.85 * mesh.bounds[1][2]


@cache
def fruits(name: str) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """The vertices of the body and of the stem of each instance, and how far the body's are below its convex hull."""
    parts = [(mesh.vertices, largest_part(mesh)) for mesh in instances(name)]
    return [(vertices[body], vertices[~body], dents(vertices[body])) for vertices, body in parts]


def _format(sides: np.ndarray) -> str | None:
    """What a battery of these sides is sold as."""
    short, middle, long = np.sort(sides)
    for name, (across, along) in ROUND_CELLS.items():
        if 0.93 * across < short <= middle <= across + 1e-9 and 0.965 * along < long <= along:
            return name
    for name, (least, most) in BLOCKS.items():
        if (np.array(least) < (short, middle, long)).all() and (np.array(most) >= (short, middle, long)).all():
            return name
    for across, along in ROUND_CELLS.values():
        ends = sorted(sides, key=lambda side: abs(side - 0.98 * along))
        cells = np.array(ends[1:]) / across
        if 0.965 * along < ends[0] <= along and tuple(np.sort(np.rint(cells))) in {(1, 2), (1, 3), (1, 4), (2, 2)}:
            return "pack" if np.abs(cells - np.rint(cells)).max() < 0.3 else None
    return None
