"""How far apart chance alone sets two settings of an ablation."""

import math
from collections.abc import Sequence

import numpy as np
from scipy import stats

from asddpg.episodes.intervals import LEVEL

FEWEST_SETTINGS = 5
EFFICIENCY = 0.37  # of the median magnitude against the mean square, for normal residuals (Rousseeuw and Croux, 1993)


def chance(values: Sequence[Sequence[float]], differences: int = 1) -> float | None:
    """Half the 95 % interval of a difference between two settings' means, from the spread of all settings.

    Three seeds say little of their own spread; a whole grid says much of it. What a run's value has beyond its setting
    and its seed is chance: the residual of a two-way layout without interaction. The standard deviation is taken from
    the median of the residuals' magnitudes, since a single setting that some seeds fail at would outweigh the others in
    a mean of squares.

    Args:
        values: (settings, seeds), all settings with the same seeds.
        differences: how many are looked at; where there are several, what the largest of them stays below in 95 % of
            all grids without any effect (Šidák's bound, which takes them for independent).

    Returns:
        None where there are too few settings or seeds to tell.
    """
    if len(values) < FEWEST_SETTINGS or len(values[0]) < 2:
        return None
    table = np.asarray(values)
    settings, seeds = table.shape
    residuals = table - table.mean(axis=1, keepdims=True)
    residuals -= np.median(residuals, axis=0)
    freedom = (settings - 1) * (seeds - 1)
    deviation = stats.median_abs_deviation(residuals, axis=None, scale="normal") * math.sqrt(table.size / freedom)
    level = LEVEL ** (1 / differences)
    return float(stats.t.ppf((1 + level) / 2, EFFICIENCY * freedom) * deviation * math.sqrt(2 / seeds))
