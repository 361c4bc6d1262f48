"""What a difference between two settings has to exceed."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from tests.tools.fake_runs import finish_group
from tools import ablation
from tools.ablation_chance import chance

SIGMA = 0.05


def _grid(seed: int) -> npt.NDArray[np.float64]:
    """Values of 18 settings of their own and 3 seeds of their own, and chance."""
    rng = np.random.default_rng(seed)
    settings, seeds = rng.uniform(0.5, 1.0, (18, 1)), rng.uniform(-0.1, 0.1, (1, 3))
    return settings + seeds + rng.normal(0.0, SIGMA, (18, 3))


def test_it_is_the_interval_of_a_difference_and_settings_and_seeds_count_for_nothing() -> None:
    told = np.mean([chance(_grid(seed).tolist()) for seed in range(300)])
    exact = 1.96 * SIGMA * math.sqrt(2 / 3)
    assert told == pytest.approx(exact, rel=0.08)


def test_one_setting_that_some_seeds_fail_at_moves_it_little() -> None:
    grids = [_grid(seed) for seed in range(100)]
    before = np.mean([chance(grid.tolist()) for grid in grids])
    for grid in grids:
        grid[3] = 0.95, 0.88, 0.2
    after = np.mean([chance(grid.tolist()) for grid in grids])
    assert after == pytest.approx(before, rel=0.15)


@pytest.mark.parametrize(("settings", "seeds"), [(4, 3), (18, 1), (0, 3)])
def test_too_little_to_tell_is_none(settings: int, seeds: int) -> None:
    assert chance(np.ones((settings, seeds)).tolist()) is None


def test_the_table_tells_it_once_enough_settings_have_all_seeds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["imitation", "n_steps", "annealing", "withdrawal", "seeds=100,101", "steps=1000", "rule_out=none"]
    grid = ablation.rows(ablation.request(words))
    names = ["paper", "paper_with_imitation", "paper_with_n_steps", "paper_with_annealing", "paper_with_withdrawal"]
    for offset, name in enumerate(names[:4]):
        finish_group(ablation.FOLDER, name, grid[name].group, [0.5, 0.5 + 0.01 * offset])
    ablation.main(["table", *words])
    assert "Chance alone" not in capsys.readouterr().out
    finish_group(ablation.FOLDER, names[4], grid[names[4]].group, [0.5, 0.54])
    ablation.main(["table", *words])
    # Residuals of half the differences, ±(0, 0.005, 0.01, 0.015, 0.02) less their median: their middle magnitude is
    # 0.005, so 0.0074 for a standard deviation, times √(10/4), times t(0.975, 4) = 2.776, times √(2/2).
    told = "two settings of 2 seeds up to 0.033 apart (95 %, from the spread of the 5 settings"
    assert told in capsys.readouterr().out
