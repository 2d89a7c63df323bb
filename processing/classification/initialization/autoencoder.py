"""The denoising convolutional auto-encoder (DCAE) whose encoder a classifier starts from (thesis 3.2.3).

Its convolutions are padded so that a stride alone changes the side, as Keras's `same` does: 32 voxels come back after
as many UP as there were halvings. The classifier's are not padded; their kernels are the same.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

import torch
from torch import nn
from torch.nn import functional

from orbitscan.processing.classification.initialization.upsampled_convolution import UpsampledConvolution
from orbitscan.processing.classification.network import BODY, Layer, Network, glorot, parse
from orbitscan.recorder.exceptions import InvalidOption

DCAE = "C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10)-UP(2)-C(16,3)-UP(2)-C(32,3)-UP(2)-C(1,5)"
_ADDED = 0.1  # voxels filled for each one emptied


@dataclass(frozen=True)
class AutoencoderSettings:
    """How the auto-encoder is trained; nothing of this is in the thesis."""

    noise: Literal["voxels", "gaussian"] = "voxels"
    level: float = 0.5  # voxels: the share of a view's occupied voxels that is emptied, a tenth as many are filled
    # elsewhere; gaussian: the standard deviation, in mean values of the view's occupied voxels
    loss: Literal["poisson", "occupancy", "mse"] = "poisson"  # poisson: the output is the logarithm of the expected
    # values, so that an empty grid is no good answer to a sparse one, and full voxels do not rule as in a mean square
    # error; occupancy: the output is the logit of whether a voxel is occupied
    epochs: int = 2
    learning_rate: float = 1e-3
    batch: int = 64  # views; for whoever makes the batches
    bfloat16: bool = False  # products in half the bits: faster where the processor has them


def mirror(structure: str = BODY, code: int = 10) -> str:
    """The shorthand of an auto-encoder: a classifier's convolutions and poolings, FC(code), and the way back.

    UP(s) undoes a pooling by s and a stride of s; the last convolution has the grid's one channel (the thesis prints
    32). The classifier's dense layers are left out. Raises InvalidOption for a structure without convolutions.
    """
    forth = [text for text in structure.split("-") if parse(text)[0].kind in "CP"]
    back: list[str] = []
    for layer in reversed(parse("-".join(forth)) if forth else ()):
        factor = layer.size if layer.kind == "P" else layer.stride
        back += [f"UP({factor})"] if factor > 1 else []
        back += [f"C({layer.size},{layer.kernel})"] if layer.kind == "C" else []
    last = max((i for i, text in enumerate(back) if text[0] == "C"), default=None)
    if last is None:
        raise InvalidOption(f"structure {structure}", "has no convolution to pretrain", "start from glorot instead")
    back[last] = f"C(1,{parse(back[last])[0].kernel})"
    return "-".join([*forth, f"FC({code})", *back])


class Autoencoder(nn.Module):
    """An auto-encoder of voxel grids: an encoder down to a code of a few numbers, a decoder back to the grid.

    Raises InvalidOption for a shorthand that does not lead from a grid to a grid.
    """

    def __init__(self, structure: str = DCAE, div: int = 32) -> None:
        super().__init__()
        layers = parse(structure)
        kinds = "".join(layer.kind[0] for layer in layers)
        dense = kinds.find("D")
        convolutions = [i for i, kind in enumerate(kinds) if kind == "C"]
        if kinds.count("D") != 1 or not set(kinds[:dense]) <= set("CP") or not set(kinds[dense + 1 :]) <= set("CU"):
            raise InvalidOption(f"structure {structure}", "is no auto-encoder", f"write it as {DCAE}")
        if convolutions[-1:] <= [dense] or layers[convolutions[-1]].size != 1:
            raise InvalidOption(f"structure {structure}", "its last convolution must be one filter", f"see {DCAE}")
        encoder, channels, side = _volume(layers[:dense], 1, div)
        width, code = channels * side**3, layers[dense].size
        self.encoder = nn.Sequential(*encoder, nn.Flatten(), nn.Linear(width, code))
        decoder, _, back = _volume(layers[dense + 1 :], channels, side, last=convolutions[-1] - dense - 1)
        if back < div:
            problem = f"its way back ends at {back} of {div} voxels"
            raise InvalidOption(f"structure {structure}", problem, "give an UP(s) for every stride and pooling by s")
        start = (nn.Linear(code, width), nn.ReLU(), nn.Unflatten(1, (channels, side, side, side)))
        self.decoder = nn.Sequential(*start, *decoder)
        self.div = div
        self.apply(glorot)
        self.to(memory_format=torch.channels_last_3d)  # type: ignore[call-overload]  # torch's stubs lack it

    def forward(self, grids: torch.Tensor) -> torch.Tensor:
        """The output that the loss compares with the clean grids, from noised grids; both are (B, 1, div, div, div)."""
        restored = self.decoder(self.encoder(grids.contiguous(memory_format=torch.channels_last_3d)))
        shown = slice(self.div)  # a side that a stride does not divide came back longer
        return restored[..., shown, shown, shown]

    @property
    def convolutions(self) -> list[nn.Conv3d]:
        """The encoder's convolutions, first to last."""
        return [module for module in self.encoder if isinstance(module, nn.Conv3d)]


def pretrain(
    batches: Callable[[], Iterable[torch.Tensor]],
    settings: AutoencoderSettings,
    seed: int,
    device: torch.device | str = "cpu",
    structure: str = DCAE,
    div: int = 32,
    report: Callable[[int, float], None] | None = None,
) -> Autoencoder:
    """An auto-encoder trained to restore clean grids from noised ones; the same seed gives the same weights.

    `batches` is asked once an epoch for grids (B, 1, div, div, div); `report` hears of every epoch (1, 2, ...) and its
    mean loss.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        autoencoder = Autoencoder(structure, div).to(device)
    generator = torch.Generator(device).manual_seed(seed)
    optimizer = torch.optim.Adam(autoencoder.parameters(), settings.learning_rate)
    for epoch in range(1, settings.epochs + 1):
        total, views = 0.0, 0
        for batch in batches():
            grids = batch.to(device)
            with torch.autocast(grids.device.type, torch.bfloat16, enabled=settings.bfloat16):
                output = autoencoder(add_noise(grids, settings, generator))
            loss = measure_loss(output.float(), grids, settings)
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            total, views = total + loss.item() * len(grids), views + len(grids)
        if report is not None:
            report(epoch, total / max(views, 1))
    return autoencoder


def add_noise(grids: torch.Tensor, settings: AutoencoderSettings, generator: torch.Generator) -> torch.Tensor:
    """Copies of grids (B, 1, div, div, div) with noise in them."""
    over = (1, 2, 3, 4)
    occupied = grids > 0
    share = occupied.float().mean(over, keepdim=True)
    value = grids.mean(over, keepdim=True) / share.clamp(min=1e-12)  # the mean of a view's occupied voxels
    if settings.noise == "gaussian":
        normal = torch.randn(grids.shape, generator=generator, device=grids.device)
        return grids + settings.level * value * normal
    drawn = torch.rand(grids.shape, generator=generator, device=grids.device)
    kept = grids * (drawn >= settings.level)
    return torch.where(~occupied & (drawn < _ADDED * settings.level * share), value, kept)


def measure_loss(output: torch.Tensor, grids: torch.Tensor, settings: AutoencoderSettings) -> torch.Tensor:
    """The loss of an output against the clean grids, both (B, 1, div, div, div): the mean over all voxels."""
    if settings.loss == "mse":
        return functional.mse_loss(output, grids)
    if settings.loss == "occupancy":
        return functional.binary_cross_entropy_with_logits(output, (grids > 0).float())
    return functional.poisson_nll_loss(output, grids, log_input=True)


def hand_over(autoencoder: Autoencoder, network: Network) -> None:
    """Copy the encoder's convolutions to the network's, in place; its dense layers stay as they are.

    Raises InvalidOption where their shapes differ.
    """
    given, taken = autoencoder.convolutions, network.convolutions
    if [c.weight.shape for c in given] != [c.weight.shape for c in taken]:
        raise InvalidOption("auto-encoder", "its convolutions are not the network's", "pretrain the same structure")
    for source, target in zip(given, taken, strict=True):
        target.load_state_dict(source.state_dict())


def _volume(
    layers: tuple[Layer, ...], channels: int, side: int, last: int | None = None
) -> tuple[list[nn.Module], int, int]:
    """(modules, channels, side) of layers on volumes of so many channels and voxels a side.

    Each convolution has its rectifier, but for the layer at `last`.
    """
    modules: list[nn.Module] = []
    factor = 1  # of an upsampling that the next layer takes in
    for i, (layer, following) in enumerate(zip(layers, (*layers[1:], None), strict=True)):
        rectifier = [] if i == last else [nn.ReLU()]
        if layer.kind == "UP":
            factor = layer.size if following and following.kind == "C" and following.stride == 1 else 1
            modules += [] if factor > 1 else [nn.Upsample(scale_factor=layer.size)]
            side *= layer.size
        elif layer.kind == "P":
            modules.append(nn.MaxPool3d(layer.size, ceil_mode=True))
            side = -(-side // layer.size)
        elif factor > 1:
            modules += [UpsampledConvolution(channels, layer.size, layer.kernel, factor), *rectifier]
            channels, factor = layer.size, 1
        else:
            out = -(-side // layer.stride)
            missing = max((out - 1) * layer.stride + layer.kernel - side, 0)
            if missing % 2:  # the further voxel behind
                modules.append(nn.ConstantPad3d((0, 1) * 3, 0.0))
            modules += [nn.Conv3d(channels, layer.size, layer.kernel, layer.stride, missing // 2), *rectifier]
            channels, side = layer.size, out
    return modules, channels, side
