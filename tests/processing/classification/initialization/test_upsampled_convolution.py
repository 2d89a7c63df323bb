"""One step in place of two: the same numbers and the same gradients."""

import pytest
import torch
from torch.nn import functional

from orbitscan.processing.classification.initialization.upsampled_convolution import UpsampledConvolution


@pytest.mark.parametrize(("kernel", "factor"), [(5, 2), (3, 2), (1, 2), (2, 2), (4, 3), (7, 2), (3, 4), (3, 1)])
def test_it_is_upsampling_and_a_padded_convolution(kernel, factor):
    torch.manual_seed(0)
    layer = UpsampledConvolution(3, 2, kernel, factor).double()
    volume = torch.rand(2, 3, 4, 4, 4, dtype=torch.float64, requires_grad=True)
    before = (kernel - 1) // 2
    large = functional.pad(functional.interpolate(volume, scale_factor=factor), (before, kernel - 1 - before) * 3)
    expected = functional.conv3d(large, layer.weight, layer.bias)
    found = layer(volume)
    torch.testing.assert_close(found, expected)
    inputs = (volume, layer.weight, layer.bias)
    towards = torch.rand_like(expected)
    for one, other in zip(
        torch.autograd.grad((found * towards).sum(), inputs),
        torch.autograd.grad((expected * towards).sum(), inputs),
        strict=True,
    ):
        torch.testing.assert_close(one, other)
