"""The layers against torch's own."""

import pytest
import torch
from torch.nn import functional

from asddpg.algorithm.layers import Convolution, Linear, Output


@pytest.mark.parametrize(("length", "kernel", "stride"), [(40, 5, 2), (18, 3, 2), (20, 3, 1), (11, 4, 3), (9, 2, 4)])
def test_convolution_and_its_gradients_are_torchs(length: int, kernel: int, stride: int) -> None:
    torch.manual_seed(0)
    layer = Convolution(3, 4, kernel, stride).double()
    signal = torch.randn(2, length, 3, dtype=torch.float64, requires_grad=True)
    weight = layer.weight.view(kernel, 3, 4).permute(2, 1, 0)
    expected = functional.conv1d(signal.transpose(1, 2), weight, layer.bias, stride).transpose(1, 2)
    found = layer(signal)
    torch.testing.assert_close(found, expected)
    leaves = (signal, layer.weight, layer.bias)
    factor = torch.randn_like(found)
    gradients = torch.autograd.grad((found * factor).sum(), leaves)
    for gradient, its in zip(gradients, torch.autograd.grad((expected * factor).sum(), leaves), strict=True):
        torch.testing.assert_close(gradient, its)


def test_an_output_layer_is_float32_where_hidden_ones_are_bfloat16() -> None:
    torch.manual_seed(0)
    hidden, output, x = Linear(8, 16), Output(16, 2), torch.randn(4, 8)
    with torch.autocast("cpu", torch.bfloat16):
        features = hidden(x)
        found = output(features)
    assert features.dtype == torch.bfloat16
    assert found.dtype == torch.float32
    torch.testing.assert_close(found, features.float() @ output.weight + output.bias)
