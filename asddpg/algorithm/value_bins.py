"""Values as distributions over bins: Q^A learned by cross-entropy in place of the squared error of Eq. 4.

Shapes: B batch, N bins.
"""

import math

import torch
from torch import Tensor, nn

MAX_BINS = 1001
_SPREAD = 0.75  # σ of a target, in widths of a bin (Farebrother et al., 2024)


class ValueBins(nn.Module):
    """N equal bins over a range of values: HL-Gauss (Imani and White, 2018; Farebrother et al., 2024).

    A target y becomes the shares that a normal distribution about y has in the bins.
    """

    edges: Tensor
    centres: Tensor

    def __init__(self, bins: int, low: float, high: float) -> None:
        """Divide the range.

        Args:
            bins: their number, five or more.
            low: least value.
            high: greatest value; both get two bins more, for the targets' tails.

        Raises:
            ValueError: there are fewer than five bins, more than MAX_BINS, or no range; a damaged file may say so.
        """
        if not (5 <= bins <= MAX_BINS and low < high):
            raise ValueError(f"a value is not over {bins} bins from {low} to {high}")
        super().__init__()
        width = (high - low) / (bins - 4)
        edges = torch.linspace(low - 2 * width, high + 2 * width, bins + 1)
        self._low, self._high, self._sigma = low, high, _SPREAD * width
        self.register_buffer("edges", edges, persistent=False)
        self.register_buffer("centres", (edges[1:] + edges[:-1]) / 2, persistent=False)

    def mean(self, logits: Tensor) -> Tensor:  # [B, N] → [B]
        """The expected values."""
        return torch.softmax(logits, dim=1) @ self.centres

    def shares(self, targets: Tensor) -> Tensor:  # [B] → [B, N]
        """What each bin has of the targets, which are clipped to the range first."""
        clipped = targets.clamp(self._low, self._high).unsqueeze(1)
        below = torch.special.erf((self.edges - clipped) / (math.sqrt(2.0) * self._sigma))
        shares: Tensor = below.diff(dim=1) / (below[:, -1:] - below[:, :1])
        return shares

    def cross_entropy(self, logits: Tensor, targets: Tensor) -> Tensor:
        """Mean over the batch of logits, [B, N], against targets, [B]."""
        return -(self.shares(targets) * torch.log_softmax(logits, dim=1)).sum(dim=1).mean()
