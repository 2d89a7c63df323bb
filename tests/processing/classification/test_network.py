"""Table 5.1's structures: shapes and parameters as they follow from the shorthand."""

import numpy as np
import pytest
import torch

from orbitscan.processing.classification.network import BODY, Layer, Network, parse
from orbitscan.recorder.exceptions import InvalidOption

# structure; parameters, (k^3 n_in + 1) n_out of each layer
TABLE = [
    ("C(16,3,2)-C(16,3)-P(2)-C(8,3)-P(2)-D(10)", 448 + 6_928 + 3_464 + 650),
    ("C(32,3,2)-C(16,3)-P(2)-C(16,3)-P(2)-D(10)", 896 + 13_840 + 6_928 + 1_290),
    ("C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-D(128)-D(10)", 4_032 + 27_680 + 13_840 + 16_512 + 1_290),
    ("C(32,3,2)-C(32,3)-P(2)-C(16,3)-P(2)-D(10)", 896 + 27_680 + 13_840 + 1_290),
    ("C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-D(10)", 4_032 + 27_680 + 13_840 + 1_290),
    ("C(64,3,2)-C(32,3)-P(2)-C(32,3)-P(2)-D(10)", 1_792 + 55_328 + 27_680 + 2_570),
    ("C(64,3,2)-C(32,3)-P(2)-C(32,3)-P(2)-D(256)-D(10)", 1_792 + 55_328 + 27_680 + 65_792 + 2_570),
]
TOTALS = [11_490, 22_954, 63_354, 43_706, 46_842, 87_370, 153_162]
SIDES = [
    [15, 13, 6, 4, 2],
    [15, 13, 6, 4, 2],
    [14, 12, 6, 4, 2],
    [15, 13, 6, 4, 2],
    [14, 12, 6, 4, 2],
    [15, 13, 6, 4, 2],
    [15, 13, 6, 4, 2],
]


def parameters(module):
    return sum(parameter.numel() for parameter in module.parameters())


@pytest.mark.parametrize(("row", "total", "sides"), list(zip(TABLE, TOTALS, SIDES, strict=True)))
def test_shapes_and_parameters_of_table_5_1(row, total, sides):
    structure, added_up = row
    network = Network(structure, 10).eval()
    assert parameters(network) == added_up == total
    volume, found = torch.rand(2, 1, 32, 32, 32), []
    for module in network.features:
        volume = module(volume)
        if isinstance(module, torch.nn.Conv3d | torch.nn.MaxPool3d):
            found.append(volume.shape[-1])
    assert found == sides
    logits, orientations = network(torch.rand(2, 1, 32, 32, 32))
    assert logits.shape == (2, 10)
    assert orientations is None


def test_the_orientation_head_reads_the_same_128_features():
    network = Network(f"{BODY}-FC(10)", 10, orientations=6)
    assert parameters(network) == 46_842 + 129 * 6
    logits, orientations = network(torch.rand(3, 1, 32, 32, 32))
    assert (logits.shape, orientations.shape) == ((3, 10), (3, 6))


@pytest.mark.parametrize(("div", "features"), [(16, None), (24, 16), (32, 128), (48, 1024)])
def test_other_grids(div, features):
    if features is None:
        with pytest.raises(InvalidOption, match="nothing of a grid of 16 voxels is left"):
            Network(f"{BODY}-FC(10)", 10, div)
    else:
        network = Network(f"{BODY}-FC(10)", 10, div)
        assert network.categories.in_features == features
        assert network(torch.rand(1, 1, div, div, div))[0].shape == (1, 10)


def test_the_shorthand_reads_as_written():
    assert parse("C(32,5,2) - UP(2)-P(3)-D(7)-FC(10)") == (
        Layer("C", 32, 5, 2),
        Layer("UP", 2),
        Layer("P", 3),
        Layer("D", 7),
        Layer("D", 10),
    )
    assert parse("C(16,3)") == (Layer("C", 16, 3, 1),)


@pytest.mark.parametrize(
    ("structure", "says"),
    [
        ("", "'' is no layer"),
        ("C(32,5,2)-X(3)-FC(10)", r"'X\(3\)' is no layer"),
        ("C(32,5,2)-FC(10", r"'FC\(10' is no layer"),
        ("C(32)-FC(10)", r"'C\(32\)' has the wrong numbers"),
        ("C(32,5,2,1)-FC(10)", "has the wrong numbers"),
        ("C(32,0)-FC(10)", "has the wrong numbers"),
        ("P(2,2)-FC(10)", "has the wrong numbers"),
        ("C(32,5,2)-P(2)", r"is no classifier; end it with FC\(10\)"),
        ("C(32,5,2)-UP(2)-FC(10)", "is no classifier"),
        ("C(32,5,2)-FC(128)-P(2)-FC(10)", "a dense layer stands before"),
        ("C(32,5,2)-FC(9)", "has 9 outputs for 10 categories"),
        ("C(32,33)-FC(10)", "nothing of a grid of 32 voxels is left"),
        ("P(2)-P(2)-P(2)-P(2)-P(2)-P(2)-FC(10)", "nothing of a grid of 32 voxels is left"),
    ],
)
def test_a_bad_structure_is_told_in_one_sentence(structure, says):
    with pytest.raises(InvalidOption, match=says) as error:
        Network(structure, 10)
    assert str(error.value).startswith(f"structure {structure}: ")
    assert "\n" not in str(error.value)


def test_weights_start_as_glorots():
    torch.manual_seed(0)
    network = Network(f"{BODY}-FC(10)", 10)
    for layer, fans in zip(network.convolutions, [(1 + 32) * 125, (32 + 32) * 27, (32 + 16) * 27], strict=True):
        limit = (6 / fans) ** 0.5
        assert float(layer.weight.detach().abs().max()) == pytest.approx(limit, rel=0.01)
        assert float(layer.weight.detach().var()) == pytest.approx(2 / fans, rel=0.05)
        assert not layer.bias.any()


def test_one_view_is_answered_as_among_others():
    network = Network(f"{BODY}-FC(10)", 10).eval()
    grids = torch.rand(5, 1, 32, 32, 32)
    torch.testing.assert_close(network(grids)[0][2:3], network(grids[2:3])[0], atol=1e-5, rtol=1e-4)


def test_cross_entropy_is_the_thesis_formula():
    """-sum t log p, added up over three views, as table 5.2 adds up its own."""
    probabilities = np.array([[0.7, 0.2, 0.1], [0.25, 0.5, 0.25], [0.1, 0.1, 0.8]])
    targets = np.array([0, 1, 0])
    by_formula = -(np.eye(3)[targets] * np.log(probabilities)).sum()
    assert by_formula == pytest.approx(-np.log(0.7 * 0.5 * 0.1))  # 3.352
    logits = torch.log(torch.from_numpy(probabilities)) + 5  # softmax takes out what all logits share
    found = torch.nn.functional.cross_entropy(logits, torch.from_numpy(targets), reduction="sum")
    assert float(found) == pytest.approx(by_formula)
