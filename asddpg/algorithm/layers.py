"""Layers laid out for small networks on a CPU; on a GPU they compute the same."""

import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor, nn
from torch.autograd.function import once_differentiable

_DRAWING = threading.RLock()


@contextmanager
def drawing_weights(seed: int = 0) -> Iterator[None]:
    """Seed torch's generator for the layers made within, then restore it; one thread at a time."""
    with _DRAWING, torch.random.fork_rng(devices=[]):
        torch.default_generator.manual_seed(seed)
        yield


class Linear(nn.Module):
    """x W + b: [B, I] → [B, J].

    W is (I, J), the transpose of torch.nn.Linear's: of a layer's three products the forward one is needed most, and
    with this layout it takes a third less time.
    """

    def __init__(self, fan_in: int, fan_out: int, bound: float | None = None) -> None:
        """Draw weights uniformly within ±bound, by default as torch.nn.Linear does, within 1/√I."""
        super().__init__()
        bound = 1.0 / math.sqrt(fan_in) if bound is None else bound
        self.weight = nn.Parameter(torch.empty(fan_in, fan_out).uniform_(-bound, bound))
        self.bias = nn.Parameter(torch.empty(fan_out).uniform_(-bound, bound))

    def forward(self, x: Tensor) -> Tensor:
        """X W + b."""
        return torch.addmm(self.bias, x, self.weight)


class Output(Linear):
    """A last layer, always in float32: in bfloat16 two values of Q would often be one, 0.4 % apart."""

    def forward(self, x: Tensor) -> Tensor:
        """X W + b, [B, J] in float32."""
        if x.dtype == self.weight.dtype:
            return super().forward(x)
        with torch.autocast(x.device.type, enabled=False):
            return super().forward(x.to(self.weight.dtype))


class Convolution(Linear):
    """1-D convolution without padding: [B, L, C] → [B, M, C'], M = ⌊(L − kernel) / stride⌋ + 1.

    For signals as short as a scan a general routine spends its time on preparations. With the channels last, windows
    are a view of the signal and the rest is one product: less than half the time, forward and back.
    """

    def __init__(self, channels: int, out_channels: int, kernel: int, stride: int) -> None:
        """Weights as torch.nn.Conv1d draws them; W is (kernel · C, C')."""
        super().__init__(kernel * channels, out_channels)
        self.kernel, self.stride = kernel, stride

    def forward(self, signal: Tensor) -> Tensor:
        """The convolution of signals."""
        windows: Tensor = _Windows.apply(signal, self.kernel, self.stride)  # type: ignore[no-untyped-call]
        return super().forward(windows.flatten(0, 1)).view(*windows.shape[:2], -1)


class _Windows(torch.autograd.Function):
    """[B, L, C] → [B, M, kernel C], each window's values side by side.

    Torch's own unfold puts the channels before the window, and its gradient is slow.
    """

    @staticmethod
    def forward(ctx: Any, signal: Tensor, kernel: int, stride: int) -> Tensor:
        batch, length, channels = signal.shape
        ctx.shape, ctx.stride, ctx.kernel = signal.shape, stride, kernel
        count = (length - kernel) // stride + 1
        strides = (length * channels, stride * channels, 1)
        return signal.contiguous().as_strided((batch, count, kernel * channels), strides).contiguous()

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, None, None]:
        channels, count = ctx.shape[2], gradient.shape[1]
        summed = gradient.new_zeros(ctx.shape)
        for offset in range(ctx.kernel):
            last = offset + (count - 1) * ctx.stride + 1
            part = gradient[:, :, offset * channels : (offset + 1) * channels]
            summed[:, offset : last : ctx.stride] += part
        return summed, None, None
