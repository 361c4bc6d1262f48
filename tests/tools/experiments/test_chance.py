"""What a difference between two settings has to exceed."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from tests.support.fake_runs import finish_group
from tools import ablation
from tools.experiments.ablation_table import chance

SIGMA = 0.05


def _grid(seed: int) -> npt.NDArray[np.float64]:
    """Values of 18 settings of their own and 3 seeds of their own, and chance."""
    rng = np.random.default_rng(seed)
    settings, seeds = rng.uniform(0.5, 1.0, (18, 1)), rng.uniform(-0.1, 0.1, (1, 3))
    return settings + seeds + rng.normal(0.0, SIGMA, (18, 3))


def test_it_is_the_interval_of_a_difference_and_settings_and_seeds_count_for_nothing() -> None:
    """One setting that some seeds fail at moves it little."""
    grids = [_grid(seed) for seed in range(300)]
    bound = np.mean([chance(grid.tolist()) for grid in grids])
    known = 1.96 * SIGMA * math.sqrt(2 / 3)  # were the spread known; that it is not widens it by a tenth
    assert bound == pytest.approx(1.1 * known, rel=0.08)
    for grid in grids:
        grid[3] = 0.95, 0.88, 0.2
    assert np.mean([chance(grid.tolist()) for grid in grids]) == pytest.approx(bound, rel=0.15)
    for too_few in ((4, 3), (18, 1), (0, 3)):
        assert chance(np.ones(too_few).tolist()) is None


@pytest.mark.parametrize("settings", [9, 18])
def test_without_any_effect_it_is_exceeded_as_rarely_as_it_says(settings: int) -> None:
    rng, grids = np.random.default_rng(0), 2000
    one, largest = 0, 0
    for _ in range(grids):
        grid = rng.normal(0.0, SIGMA, (settings, 3))
        differences = np.abs((grid - grid[0]).mean(axis=1))
        one += differences[1] < (chance(grid.tolist()) or 0.0)
        largest += differences.max() < (chance(grid.tolist(), differences=settings - 1) or 0.0)
    assert one / grids == pytest.approx(0.95, abs=0.015)
    assert 0.95 < largest / grids < 0.99  # the differences share a setting, so this bound is rather wide


def test_the_table_states_it_once_enough_settings_have_all_seeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = ["imitation", "n_steps", "annealing", "withdrawal", "seeds=100,101", "steps=1000", "rule_out=null"]
    grid = ablation.make_grid(*ablation.parse(arguments))
    names = ["paper", "paper_with_imitation", "paper_with_n_steps", "paper_with_annealing", "paper_with_withdrawal"]
    for offset, name in enumerate(names[:4]):
        finish_group(ablation.FOLDER, grid[name], [0.5, 0.5 + 0.01 * offset])
    ablation.main(["table", *arguments])
    assert "Chance alone" not in capsys.readouterr().out
    finish_group(ablation.FOLDER, grid[names[4]], [0.5, 0.54])
    ablation.main(["table", *arguments])
    # Residuals of half the differences, ±(0, 0.005, 0.01, 0.015, 0.02) less their median: their middle magnitude is
    # 0.005, so 0.0074 for a standard deviation, times √(10/4), times √(2/2), times t(0.975, 0.37 · 4) = 6.13 or, for
    # the largest of four, t(0.9936, 0.37 · 4) = 15.6.
    printed = capsys.readouterr().out
    assert "2 seeds up to 0.072 apart (95 %, from the spread of the 5 settings with all seeds)" in printed
    assert "among 4 differences chance gives one of up to 0.183" in printed
