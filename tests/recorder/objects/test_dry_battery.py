import numpy as np
import pytest

from orbitscan.recorder.objects import dry_battery
from orbitscan.recorder.objects.dry_battery import CELLS, LABELS
from orbitscan.recorder.objects.mesh import Mesh
from tests.recorder.test_objects import assert_closed_and_outward

IEC = {  # the largest diameter and length of IEC 60086-2 [m]
    "AAA": (0.0105, 0.0445),
    "AA": (0.0145, 0.0505),
    "C": (0.0262, 0.0500),
    "D": (0.0342, 0.0615),
}
ROUND = len(dry_battery._cell(np.random.default_rng(0), "AA", LABELS[0]).triangles)
seeds = pytest.mark.parametrize("seed", range(12))


@pytest.fixture(scope="module")
def batteries() -> list[Mesh]:
    return [dry_battery.build(np.random.default_rng(seed)) for seed in range(120)]


def sides(mesh: Mesh) -> np.ndarray:
    return np.ptp(mesh.vertices, axis=0)


def test_batteries_are_closed_and_within_the_limits(batteries):
    for mesh in batteries:
        assert_closed_and_outward(mesh)
        assert 1000 < len(mesh.triangles) < 10_000
        assert mesh.colors.shape == mesh.vertices.shape


def test_every_kind_comes_in_every_hundred_standing_and_lying(batteries):
    seen = set()
    for mesh in batteries:
        standing = sides(mesh)[2] > sides(mesh)[0]
        seen |= {
            (size, standing)
            for size, (across, along) in IEC.items()
            for low, middle, high in [np.sort(sides(mesh))]
            if low == pytest.approx(across, rel=0.07) and middle == pytest.approx(across, rel=0.07) and high <= along
        }
    assert {("AA", True), ("AA", False), ("C", True), ("C", False), ("D", True), ("D", False)} <= seen
    assert {("AAA", False)} <= seen
    assert np.mean([sides(mesh).max() > 0.09 for mesh in batteries]) > 0.03  # lanterns


@seeds
@pytest.mark.parametrize("size", CELLS)
def test_a_cell_is_of_its_real_size_and_bears_a_nub_on_top(size, seed):
    mesh = dry_battery._cell(np.random.default_rng(seed), size, LABELS[0])
    across, along = IEC[size]
    assert sides(mesh)[0] == pytest.approx(sides(mesh)[1])
    assert 0.93 * across < sides(mesh)[0] <= across
    assert 0.965 * along < sides(mesh)[2] <= along
    radii, z = np.hypot(*mesh.vertices.T[:2]), mesh.vertices[:, 2]
    assert 0.1 * across < radii[z > z.max() - 0.0005].max() < 0.25 * across
    assert radii[z < 0.0005].max() > 0.4 * across


def test_a_lying_cell_points_its_plus_pole_to_the_front(batteries):
    lying = [mesh for mesh in batteries if len(mesh.triangles) == ROUND and sides(mesh)[0] > 1.5 * sides(mesh)[1]]
    assert len(lying) > 10
    for mesh in lying:
        x = mesh.vertices[:, 0]
        front, back = (
            np.hypot(*np.ptp(mesh.vertices[at, 1:], axis=0)) for at in (x > x.max() - 0.0005, x < x.min() + 0.0005)
        )
        assert front < 0.6 * back


@seeds
def test_a_pack_holds_whole_cells_side_by_side(seed):
    mesh = dry_battery._pack(np.random.default_rng(seed), LABELS[0])
    assert_closed_and_outward(mesh)
    depth, width, height = sides(mesh)
    fits = [
        (round(depth / across), round(width / across))
        for across, along in IEC.values()
        if 0.965 * along < height <= along and abs(depth / across - round(depth / across)) < 0.12
    ]
    assert {(1, 2), (1, 3), (1, 4), (2, 2)} & set(fits)


@seeds
def test_a_nine_volt_block_bears_its_snaps_half_an_inch_apart(seed):
    mesh = dry_battery._nine_volt(np.random.default_rng(seed), LABELS[0])
    depth, width, height = sides(mesh)
    assert 0.0155 < depth <= 0.0175
    assert 0.0245 < width <= 0.0265
    assert height + 0.0005 > 0.0465
    assert height <= 0.0493
    y = mesh.vertices[mesh.vertices[:, 2] > mesh.vertices[:, 2].max() - 0.001, 1]
    assert y.max() > 0.006
    assert y.min() < -0.006
    assert np.abs(y).min() > 0.0015
    wide = np.ptp(y[y > 0]), np.ptp(y[y < 0])
    assert max(wide) > 1.3 * min(wide)  # the minus snap is flared
    assert np.mean([y[y > 0].min() + y[y > 0].max(), -y[y < 0].min() - y[y < 0].max()]) == pytest.approx(
        0.0127, abs=1e-4
    )


@seeds
def test_flat_and_lantern_blocks_are_of_their_real_sizes(seed):
    depth, width, height = sides(dry_battery._flat(np.random.default_rng(seed), LABELS[0]))
    assert 0.0199 < depth < 0.0221
    assert 0.0599 < width < 0.0621
    assert 0.063 < height < 0.077
    depth, width, height = sides(dry_battery._lantern(np.random.default_rng(seed), LABELS[0]))
    assert 0.063 < width <= depth < 0.0671
    assert 0.097 < height < 0.117
