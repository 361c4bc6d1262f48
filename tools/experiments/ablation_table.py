"""The ablation's table: what each factor changes, what chance alone changes, and what the first seed rules out."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import stats

from asddpg.episodes.intervals import LEVEL, Estimate, mean
from tools.experiments.run_metrics import METRICS, Metric
from tools.experiments.run_store import FinishedRun, Results
from tools.experiments.runs import Group
from tools.experiments.tables import LEGEND, markdown, mean_cell, missing_note, value_cell

EFFECT_ON = "success_last"
SHOWN = [
    "success_last",
    "collision_last",
    "success_best",
    "success_training",
    "share_end",
    "switch_prefers",
    "last_five",
    "swing",
]
EFFECT = Metric("effect on success rate", "{:+.3f}", is_share=False)
FEWEST_SETTINGS = 5
EFFICIENCY = 0.37  # of the median magnitude against the mean square, for normal residuals (Rousseeuw and Croux, 1993)
UNKNOWN = Estimate(None, None, None)


def ablation_table(title: str, grid: Mapping[str, Group], results: Results) -> str:
    """A table for each root of the grid; groups without a finished run are left out."""
    shown = METRICS[EFFECT_ON].title
    header = ["setting", "seeds", f"{shown}, by seed", EFFECT.title, *(METRICS[name].title for name in SHOWN)]
    against = "from the first row, or from the one that is named"
    parts = [title, f"Effect: difference of {shown} {against}, paired by seed."]
    for root in (name for name, group in grid.items() if group.reference is None):
        rows = _rows(root, grid, results)
        parts += [markdown(header, rows), *_chance_note(root, grid, results)] if rows else []
    return "\n\n".join([*parts, LEGEND])


def screen(grid: Mapping[str, Group], results: Results, margin: float) -> dict[str, Group]:
    """The grid; groups that their first seed rules out keep the runs there are, and say so in their title.

    Ruled out is a group that falls short of its reference by more than `margin`, or reaches less than `margin` at all.
    A root stays, and so does the reference of a group that stays.
    """

    def first_rate(name: str) -> float | None:
        return _rates(results[name]).get(grid[name].seeds[0])

    kept: set[str | None] = set()
    for name, group in grid.items():
        rate, base = first_rate(name), first_rate(group.reference or name)
        falls_short = rate is not None and (rate < margin or (base is not None and rate < base - margin))
        if group.reference is None or not falls_short:
            kept |= set(_references(name, grid))
    return {name: group if name in kept else _rule_out(group, results[name]) for name, group in grid.items()}


def _rule_out(group: Group, runs: Mapping[int, FinishedRun]) -> Group:
    is_whole = len(runs) == len(group.seeds)
    return group if is_whole else replace(group, title=f"{group.title} (ruled out)", seeds=tuple(runs))


def _references(name: str, grid: Mapping[str, Group]) -> list[str]:
    """A group, its reference, the reference of that, up to the root."""
    reference = grid[name].reference
    return [name, *(_references(reference, grid) if reference else [])]


def _rates(runs: Mapping[int, FinishedRun]) -> dict[int, float]:
    return {seed: value for seed, run in runs.items() if (value := run.metrics[EFFECT_ON]) is not None}


def _rows(root: str, grid: Mapping[str, Group], results: Results) -> list[list[str]]:
    effects = {root: UNKNOWN}
    for name, group in grid.items():
        if group.reference and _references(name, grid)[-1] == root:
            base = _rates(results[group.reference])
            rates = _rates(results[name]).items()
            effects[name] = mean([rate - base[seed] for seed, rate in rates if seed in base])
    # The root first, then the largest effect; those not known yet at the end.
    order = sorted(effects, key=lambda name: (name != root, effects[name].value is None, -(effects[name].value or 0.0)))
    return [_row(grid[name], root, grid, results[name], effects[name]) for name in order if results[name]]


def _row(
    group: Group, root: str, grid: Mapping[str, Group], runs: Mapping[int, FinishedRun], effect: Estimate
) -> list[str]:
    against = f", against {grid[group.reference].title}" if group.reference not in (None, root) else ""
    return [
        group.title + against + missing_note(group, len(runs)),
        ", ".join(str(seed) for seed in runs),
        ", ".join(value_cell(EFFECT_ON, run) for run in runs.values()),
        EFFECT.cell(effect),
        *(mean_cell(metric, runs.values()) for metric in SHOWN),
    ]


def _chance_note(root: str, grid: Mapping[str, Group], results: Results) -> list[str]:
    """What a difference has to exceed; nothing where there are too few runs."""
    seeds = grid[root].seeds
    rates = [_rates(results[name]) for name in grid if _references(name, grid)[-1] == root]
    complete = [[by_seed[seed] for seed in seeds] for by_seed in rates if set(seeds) <= set(by_seed)]
    apart, others = chance(complete), len(complete) - 1
    if apart is None:
        return []
    return [
        f"Chance alone sets two settings of {len(seeds)} seeds up to {apart:.3f} apart (95 %, from the spread of the "
        f"{len(complete)} settings with all seeds). The largest of all differences has to exceed more: among {others} "
        f"differences chance gives one of up to {chance(complete, others):.3f}."
    ]


def chance(values: Sequence[Sequence[float]], differences: int = 1) -> float | None:
    """Half the 95 % interval of a difference between two settings' means, from the spread of all settings.

    Three seeds say little of their own spread; a whole grid says much of it. What a run's value has beyond its setting
    and its seed is chance: the residual of a two-way layout without interaction. The standard deviation is taken from
    the median of the residuals' magnitudes, since a single setting that some seeds fail at would outweigh the others in
    a mean of squares.

    Args:
        values: (settings, seeds), all settings with the same seeds.
        differences: how many are looked at; of several, what the largest stays below in 95 % of all grids without any
            effect (Šidák's bound, which takes them for independent).

    Returns:
        None where there are too few settings or seeds.
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
