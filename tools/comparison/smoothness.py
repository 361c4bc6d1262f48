"""How smoothly a robot was steered: sums over the changes of the turn rate from one decision to the next."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

LARGE_CHANGE = 0.5  # rad/s
TURNING = 0.3  # rad/s; a slower turn on either side makes no flip


@dataclass(frozen=True)
class Smoothness:
    """Of an episode.

    Attributes:
        changes: one less than the steps.
        total_change: sum of |ω_t − ω_{t−1}|, rad/s.
        large_changes: those above LARGE_CHANGE.
        sign_flips: changes from turning one way to turning the other, both faster than TURNING.
    """

    changes: int
    total_change: float
    large_changes: int
    sign_flips: int


def measure_smoothness(turn_rates: Sequence[float]) -> Smoothness:
    """The sums over an episode's executed turn rates, rad/s, one a step."""
    rates = np.array(turn_rates, dtype=np.float64)
    before, after = rates[:-1], rates[1:]
    changes = np.abs(after - before)
    flips = (before * after < 0) & (np.minimum(np.abs(before), np.abs(after)) > TURNING)
    return Smoothness(
        len(changes), float(changes.sum()), int(np.count_nonzero(changes > LARGE_CHANGE)), int(np.count_nonzero(flips))
    )
