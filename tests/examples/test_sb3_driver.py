"""A policy of Stable-Baselines3, trained on the task as anyone would, beside a driver of ours."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import tasks
from asddpg.errors import UserError
from tools import compare
from tools.comparison.cases import Case
from tools.comparison.driven_episodes import DrivenCase

pytestmark = [pytest.mark.long, pytest.mark.filterwarnings("ignore:.*symmetric and normalized")]


def train(algorithm: str, path: Path, seed: int = 0, **arguments: Any) -> Any:
    """A model of some hundred steps, saved."""
    library = pytest.importorskip("stable_baselines3")
    env = gymnasium.make("asddpg/NavEmpty-v0", **arguments)
    kind = getattr(library, algorithm)
    model = kind("MlpPolicy", env, seed=seed, device="cpu", learning_starts=100, policy_kwargs={"net_arch": [32, 32]})
    model.learn(300)
    model.save(path)
    return model


@pytest.mark.parametrize("algorithm", ["DDPG", "TD3", "SAC"])
def test_a_model_drives_as_it_does_in_its_own_library(
    algorithm: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    model = train(algorithm, tmp_path / "model.zip")
    monkeypatch.setenv("SB3_MODEL", str(tmp_path / "model.zip"))
    folder = tmp_path / "compare"
    arguments = ["tasks=[nav_empty]", "episodes=2", "processes=1", f"folder={folder}"]
    compare.main(["drivers=[examples.sb3_driver:Factory,controller]", *arguments])
    assert "| examples.sb3_driver:Factory | nav_empty | 2 |" in capsys.readouterr().out
    (path,) = folder.glob("examples.sb3_driver_Factory_nav_empty_*.json")
    (first, _) = DrivenCase.read(path).episodes
    env = gymnasium.make("asddpg/NavEmpty-v0")
    env.reset(seed=0)
    observation, _ = env.reset(options={"start": first.start, "goal": first.goal})
    steps, is_over = 0, False
    while not is_over:
        observation, _, terminated, truncated, _ = env.step(model.predict(observation, deterministic=True)[0])
        steps, is_over = steps + 1, terminated or truncated
    assert first.episode.steps == steps


def test_another_model_is_driven_anew_and_one_of_other_speeds_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, folder = tmp_path / "model.zip", tmp_path / "compare"
    monkeypatch.setenv("SB3_MODEL", str(path))
    arguments = ["drivers=[examples.sb3_driver:Factory]", "tasks=[nav_empty]", "episodes=1", "processes=1"]
    for seed in range(2):
        train("SAC", path, seed)
        compare.main([*arguments, f"folder={folder}"])
    assert len(list(folder.glob("*.json"))) == 2
    train("SAC", path, config={"max_linear_velocity": 0.4})
    with pytest.raises(UserError, match=r"the actions of .*model\.zip go from .* to \[0\.4"):
        compare.main([*arguments, f"folder={folder}"])
    monkeypatch.delenv("SB3_MODEL")
    with pytest.raises(UserError, match="SB3_MODEL must name a file"):
        compare.main([*arguments, f"folder={folder}"])


@pytest.mark.parametrize("task", tasks.ALL_TASKS)
def test_an_own_driver_has_the_actions_of_gymnasiums_environment(task: str, tmp_path: Path) -> None:
    own = Case("tests.support.own_driver:Forward", task, 1).set_up(tmp_path).environment.action_space
    theirs = gymnasium.make(tasks.gymnasium_id(task)).action_space
    assert isinstance(own, gymnasium.spaces.Box)
    assert isinstance(theirs, gymnasium.spaces.Box)
    np.testing.assert_array_equal([own.low, own.high], [theirs.low, theirs.high])
