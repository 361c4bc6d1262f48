"""95 % intervals."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

LEVEL = 0.95


class Estimate(NamedTuple):
    """A figure with its 95 % interval; None where there was nothing to measure."""

    value: float | None
    low: float | None
    high: float | None


def rate(hits: int, trials: int) -> Estimate:
    """A share with Wilson's score interval."""
    if trials == 0:
        return Estimate(None, None, None)
    interval = stats.binomtest(hits, trials).proportion_ci(LEVEL, method="wilson")
    return Estimate(hits / trials, float(interval.low), float(interval.high))


def mean(values: Sequence[float], low: float = -math.inf, high: float = math.inf) -> Estimate:
    """A mean with Student's t interval, cut at bounds of the values; without one for a single value."""
    if not len(values):
        return Estimate(None, None, None)
    centre = float(np.mean(values))
    if len(values) == 1:
        return Estimate(centre, None, None)
    half = float(stats.t.ppf((1 + LEVEL) / 2, len(values) - 1) * np.std(values, ddof=1) / math.sqrt(len(values)))
    return Estimate(centre, max(centre - half, low), min(centre + half, high))
