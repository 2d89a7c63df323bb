"""Voxel networks from the thesis's shorthand (3.2): `C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10)`."""

import re
from dataclasses import dataclass

import torch
from torch import nn

from orbitscan.recorder.exceptions import InvalidOption

BODY = "C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)"  # table 5.1's best; a dense layer for the categories follows
DROPOUT = 0.1  # not in the thesis
_LAYER = re.compile(r"(C|P|UP|FC|D)\((\d+(?:,\d+)*)\)")
_REMEDY = "write layers as in C(32,5,2)-C(32,3)-P(2)-C(16,3)-P(2)-FC(10)"


@dataclass(frozen=True)
class Layer:
    """One layer of the shorthand."""

    kind: str  # C: convolution, P: max pooling, UP: upsampling, D: dense
    size: int  # filters of C, factor of P and UP, outputs of D
    kernel: int = 0  # of C, on each of the three axes
    stride: int = 1  # of C


def parse(structure: str) -> tuple[Layer, ...]:
    """The layers a shorthand names; raises InvalidOption for one that cannot be read."""
    layers = []
    for text in structure.replace(" ", "").split("-"):
        match = _LAYER.fullmatch(text)
        if match is None:
            raise InvalidOption(f"structure {structure}", f"'{text}' is no layer", _REMEDY)
        kind, numbers = match[1], [int(number) for number in match[2].split(",")]
        if len(numbers) not in ((2, 3) if kind == "C" else (1,)) or min(numbers) < 1:
            raise InvalidOption(f"structure {structure}", f"'{text}' has the wrong numbers", _REMEDY)
        layers.append(Layer(kind.replace("FC", "D"), *numbers))
    return tuple(layers)


class Network(nn.Module):
    """A classifier of voxel grids: convolutions, pooling and dense layers, with an orientation head where asked for.

    Raises InvalidOption for a structure that is no classifier of so many categories, or too deep for the grid.
    """

    def __init__(
        self, structure: str, categories: int, div: int = 32, orientations: int = 0, dropout: float = DROPOUT
    ) -> None:
        super().__init__()
        layers = parse(structure)
        _check(structure, layers, categories)
        modules: list[nn.Module] = []
        channels, side, width = 1, div, 0  # width: of the features, once they are flat
        for layer in layers[:-1]:
            if layer.kind == "C":
                modules += [nn.Conv3d(channels, layer.size, layer.kernel, layer.stride), nn.ReLU()]
                channels, side = layer.size, (side - layer.kernel) // layer.stride + 1
            elif layer.kind == "P":
                modules += [nn.MaxPool3d(layer.size), nn.Dropout(dropout)]
                side //= layer.size
            else:
                if not width:
                    modules.append(nn.Flatten())
                modules += [nn.Linear(width or channels * side**3, layer.size), nn.ReLU(), nn.Dropout(dropout)]
                width = layer.size
            if side < 1:
                problem = f"nothing of a grid of {div} voxels is left after its layers"
                raise InvalidOption(f"structure {structure}", problem, "take smaller kernels, or fewer poolings")
        if not width:
            modules.append(nn.Flatten())
        width = width or channels * side**3
        self.features = nn.Sequential(*modules)
        self.categories = nn.Linear(width, categories)
        self.orientations = nn.Linear(width, orientations) if orientations else None
        self.apply(glorot)
        self.to(memory_format=torch.channels_last_3d)  # type: ignore[call-overload]  # twice as fast on a CPU

    def forward(self, grids: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor | None]:
        """Logits (B, categories), and (B, orientations) or None, of grids (B, 1, div, div, div)."""
        features = self.features(grids.contiguous(memory_format=torch.channels_last_3d))  # (B, 128) by default
        return self.categories(features), None if self.orientations is None else self.orientations(features)

    @property
    def convolutions(self) -> list[nn.Conv3d]:
        """The convolutions, first to last."""
        return [module for module in self.features if isinstance(module, nn.Conv3d)]


def glorot(module: nn.Module) -> None:
    """Give a layer Glorot's uniform weights and no bias, in place (the thesis's random initialisation)."""
    if isinstance(module, nn.Conv3d | nn.Linear):
        nn.init.xavier_uniform_(module.weight)
        if module.bias is not None:
            nn.init.zeros_(module.bias)


def _check(structure: str, layers: tuple[Layer, ...], categories: int) -> None:
    kinds = "".join(layer.kind[0] for layer in layers)
    if "U" in kinds or kinds[-1] != "D":
        raise InvalidOption(f"structure {structure}", "is no classifier", f"end it with FC({categories}), without UP")
    if "D" in kinds.rstrip("D"):
        raise InvalidOption(f"structure {structure}", "a dense layer stands before a convolution or pooling", _REMEDY)
    if layers[-1].size != categories:
        problem = f"has {layers[-1].size} outputs for {categories} categories"
        raise InvalidOption(f"structure {structure}", problem, f"end it with FC({categories})")
