"""Parameters side by side in one vector: optimiser and soft update become one operation each.

A small network's update on a CPU is spent in the overhead of many small operations, not in arithmetic.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn


class FlatParameters:
    """A vector that holds the values of parameters; the modules go on using them as views.

    Attributes:
        vector: all values, one after the other; an optimiser steps on it as on a single parameter.
    """

    def __init__(self, parameters: Sequence[nn.Parameter]) -> None:
        """Move the parameters' values into one vector; changes where they are stored, not what they are."""
        self._parameters = list(parameters)
        self.vector = torch.cat([parameter.detach().reshape(-1) for parameter in self._parameters])
        self.vector.grad = torch.zeros_like(self.vector)
        sizes = [parameter.numel() for parameter in self._parameters]
        for parameter, part in zip(self._parameters, torch.split(self.vector, sizes), strict=True):
            parameter.data = part.view_as(parameter)

    def backward(self, loss: Tensor) -> None:
        """Write the gradient of `loss`, and of nothing before it, into `vector.grad`."""
        gradients = torch.autograd.grad(loss, self._parameters)
        torch.cat([gradient.reshape(-1) for gradient in gradients], out=self.vector.grad)

    def soft_update(self, online: "FlatParameters", tau: float) -> None:
        """Soft update: θ' ← τ θ + (1 − τ) θ'."""
        self.vector.lerp_(online.vector, tau)

    def load(self, vector: Tensor) -> None:
        """Copy values in.

        Raises:
            ValueError: there are more or fewer than here.
        """
        if vector.shape != self.vector.shape:
            raise ValueError(f"{len(self.vector)} parameters cannot take {len(vector)} values")
        self.vector.copy_(vector)
