"""The denoising auto-encoder: its shape from a shorthand, its noise, what it learns, what it hands over."""

import numpy as np
import pytest
import torch

from orbitscan.processing.classification.initialization.autoencoder import (
    DCAE,
    Autoencoder,
    AutoencoderSettings,
    add_noise,
    hand_over,
    measure_loss,
    mirror,
    pretrain,
)
from orbitscan.processing.classification.network import BODY, Network
from orbitscan.recorder.exceptions import InvalidOption

SMALL = "C(8,5,2)-C(8,3)-P(2)"


def balls(count, div, seed=0):
    """Grids of hollow balls of several radii, a few points in every voxel of the shell."""
    rng = np.random.default_rng(seed)
    axes = np.stack(np.meshgrid(*[np.arange(div) - (div - 1) / 2] * 3, indexing="ij"))
    distances = np.linalg.norm(axes, axis=0)
    radii = rng.uniform(div / 6, div / 2.2, count)
    shells = np.abs(distances[None] - radii[:, None, None, None]) < 0.7
    return torch.from_numpy(shells * rng.poisson(3, shells.shape)).float()[:, None]


def test_the_thesis_shapes_and_parameters():
    autoencoder = Autoencoder()
    count = {
        name: sum(parameter.numel() for parameter in part.parameters()) for name, part in autoencoder.named_children()
    }
    assert count["encoder"] == 4_032 + 27_680 + 13_840 + 10_250
    assert count["decoder"] == 11_264 + 6_928 + 13_856 + 4_001
    assert sum(count.values()) == 91_851
    volume, sides = torch.rand(2, 1, 32, 32, 32), []
    for module in autoencoder.encoder:
        volume = module(volume)
        if isinstance(module, torch.nn.Conv3d | torch.nn.MaxPool3d):
            sides.append(volume.shape[-1])
    assert sides == [16, 16, 8, 8, 4]
    assert volume.shape == (2, 10)
    assert autoencoder(torch.rand(2, 1, 32, 32, 32)).shape == (2, 1, 32, 32, 32)
    assert isinstance(list(autoencoder.modules())[-1], torch.nn.Conv3d)  # unrectified


@pytest.mark.parametrize("end", ["", "-FC(10)", "-D(128)-D(10)"])
def test_the_thesis_auto_encoder_is_the_mirror_of_its_classifier(end):
    assert mirror(BODY + end) == DCAE


@pytest.mark.parametrize(
    ("structure", "mirrored", "div"),
    [
        ("C(16,3,2)-C(16,3)-P(2)-C(8,3)-P(2)-D(10)", "-UP(2)-C(8,3)-UP(2)-C(16,3)-UP(2)-C(1,3)", 32),
        ("C(8,4,3)-P(2)-FC(10)", "-UP(2)-UP(3)-C(1,4)", 25),
        ("P(2)-C(8,3)-FC(10)", "-C(1,3)-UP(2)", 15),
        (BODY, "-UP(2)-C(16,3)-UP(2)-C(32,3)-UP(2)-C(1,5)", 30),
    ],
)
def test_any_body_is_mirrored_and_any_grid_comes_back_whole(structure, mirrored, div):
    shorthand = mirror(structure)
    assert shorthand.split("-FC(10)")[1] == mirrored
    assert Autoencoder(shorthand, div)(torch.rand(2, 1, div, div, div)).shape == (2, 1, div, div, div)


@pytest.mark.parametrize(
    ("structure", "says"),
    [
        ("C(32,5,2)-UP(2)-C(1,5)", "is no auto-encoder"),
        ("C(32,5,2)-FC(10)-FC(10)-UP(2)-C(1,5)", "is no auto-encoder"),
        ("C(32,5,2)-UP(2)-FC(10)-UP(2)-C(1,5)", "is no auto-encoder"),
        ("C(32,5,2)-FC(10)-P(2)-C(1,5)", "is no auto-encoder"),
        ("C(32,5,2)-FC(10)-UP(2)-C(32,5)", "last convolution must be one filter"),
        ("C(1,5,2)-FC(10)-UP(2)", "last convolution must be one filter"),
        ("FC(10)-UP(2)", "last convolution must be one filter"),
        ("C(32,5,2)-P(2)-FC(10)-UP(2)-C(1,5)", "its way back ends at 16 of 32 voxels"),
        ("C(32,5,2)-Q(2)", r"'Q\(2\)' is no layer"),
    ],
)
def test_a_bad_structure_is_told_in_one_sentence(structure, says):
    with pytest.raises(InvalidOption, match=says) as error:
        Autoencoder(structure)
    assert "\n" not in str(error.value)


def test_a_structure_without_convolution_has_no_auto_encoder():
    with pytest.raises(InvalidOption, match="has no convolution to pretrain"):
        mirror("P(4)-FC(10)")


def test_noise_empties_its_share_of_voxels_and_fills_a_tenth_as_many():
    grids = balls(40, 32)
    before = grids.clone()
    noised = add_noise(grids, AutoencoderSettings(level=0.4), torch.Generator().manual_seed(0))
    assert torch.equal(grids, before)
    occupied = grids > 0
    assert float((noised[occupied] == 0).float().mean()) == pytest.approx(0.4, abs=0.01)
    kept = occupied & (noised > 0)
    assert torch.equal(noised[kept], grids[kept])
    filled = ~occupied & (noised > 0)
    assert float(filled.sum() / occupied.sum()) == pytest.approx(0.04, rel=0.1)
    for grid, noise, new in zip(grids, noised, filled, strict=True):
        assert noise[new].tolist() == pytest.approx([float(grid[grid > 0].mean())] * int(new.sum()))


def test_gaussian_noise_is_measured_in_the_views_own_values():
    grids = balls(4, 32) * torch.tensor([1.0, 2, 4, 8])[:, None, None, None, None]
    noised = add_noise(grids, AutoencoderSettings("gaussian", 0.3), torch.Generator().manual_seed(0))
    means = [float(grid[grid > 0].mean()) for grid in grids]
    assert (noised - grids).flatten(1).std(dim=1).tolist() == pytest.approx([0.3 * m for m in means], rel=0.02)


def test_an_empty_grid_stays_a_number():
    noised = add_noise(torch.zeros(1, 1, 8, 8, 8), AutoencoderSettings(), torch.Generator().manual_seed(0))
    assert not noised.any()


def test_losses_are_least_where_the_output_says_the_grid():
    grids = balls(2, 16)
    outputs = {"poisson": torch.log(grids.clamp(min=1e-6)), "mse": grids, "occupancy": 20 * (grids > 0).float() - 10}
    for kind, best in outputs.items():
        settings = AutoencoderSettings(loss=kind)
        least = float(measure_loss(best, grids, settings))
        for other in (best / 2, best.roll(1, 2), torch.zeros_like(best)):
            assert float(measure_loss(other, grids, settings)) > least, kind


@pytest.fixture(scope="module")
def trained():
    grids = balls(32, 16)
    heard = []
    settings = AutoencoderSettings(epochs=12, learning_rate=3e-3)
    autoencoder = pretrain(lambda: grids.split(8), settings, 0, "cpu", mirror(SMALL), 16, lambda *e: heard.append(e))
    return autoencoder, settings, heard


def test_it_restores_unseen_shapes_better_than_any_constant_grid(trained):
    autoencoder, settings, _ = trained
    grids = balls(64, 16, seed=1)
    with torch.no_grad():
        output = autoencoder(add_noise(grids, settings, torch.Generator().manual_seed(1)))
    rate = float(measure_loss(torch.log(grids.mean()).expand_as(grids), grids, settings))
    mean_grid = float(measure_loss(torch.log(grids.mean(0).clamp(min=1e-6)).expand_as(grids), grids, settings))
    found = float(measure_loss(output, grids, settings))
    assert found < mean_grid < rate


def test_each_epoch_is_reported_and_the_loss_falls(trained):
    _, _, heard = trained
    assert [epoch for epoch, _ in heard] == list(range(1, 13))
    assert heard[-1][1] < heard[0][1]


def test_the_same_seed_gives_the_same_weights_whatever_was_drawn_before():
    grids = balls(8, 16)

    def weights(seed):
        torch.rand(3)
        autoencoder = pretrain(lambda: [grids], AutoencoderSettings(epochs=2), seed, "cpu", mirror(SMALL), 16)
        return torch.cat([parameter.detach().flatten() for parameter in autoencoder.parameters()])

    assert torch.equal(weights(0), weights(0))
    assert not torch.equal(weights(0), weights(1))


def test_half_the_bits_learn_too():
    grids = balls(16, 16)
    heard = []
    settings = AutoencoderSettings(epochs=6, bfloat16=True)
    pretrain(lambda: [grids], settings, 0, "cpu", mirror(SMALL), 16, lambda *epoch: heard.append(epoch))
    assert heard[-1][1] < heard[0][1]


def test_handing_over_copies_the_convolutions_and_nothing_else():
    torch.manual_seed(3)
    autoencoder, network = Autoencoder(), Network(f"{BODY}-FC(128)-FC(10)", 10, orientations=6)
    for convolution in autoencoder.convolutions:
        torch.nn.init.normal_(convolution.bias)
    before = {name: value.clone() for name, value in network.state_dict().items()}
    hand_over(autoencoder, network)
    for given, taken in zip(autoencoder.convolutions, network.convolutions, strict=True):
        assert torch.equal(given.weight, taken.weight)
        assert torch.equal(given.bias, taken.bias)
        assert given.weight.data_ptr() != taken.weight.data_ptr()
    changed = {name for name, value in network.state_dict().items() if not torch.equal(value, before[name])}
    assert changed == {f"features.{i}.{what}" for i in (0, 2, 6) for what in ("weight", "bias")}


@pytest.mark.parametrize("other", ["C(32,5,2)-C(32,3)-P(2)-FC(10)", "C(32,3,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10)"])
def test_an_encoder_of_another_structure_is_refused(other):
    network = Network(other, 10)
    before = [value.clone() for value in network.state_dict().values()]
    with pytest.raises(InvalidOption, match="its convolutions are not the network's"):
        hand_over(Autoencoder(), network)
    assert all(torch.equal(a, b) for a, b in zip(before, network.state_dict().values(), strict=True))
