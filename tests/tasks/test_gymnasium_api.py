"""Whatever Gymnasium puts around an environment: options of make, specs, wrappers, vectors, other processes."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode

import tasks
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Decision, Driver
from tests.conftest import ROOT

ID = "asddpg/NavComplex-v0"
LIMITED: dict[str, Any] = {"max_episode_steps": 5}
CHECKED: dict[str, Any] = {"disable_env_checker": False}
NUMPY: dict[str, Any] = {"time_limit_steps": np.int64(9), "goal_radius": np.float32(0.2)}
NOT_PLAIN: dict[str, Any] = {
    "config": tasks.NavigationConfig(**NUMPY, laser=tasks.LaserConfig(noise=0.2)),
    "reward": tasks.Reward(progress=2.0),
    "num_scans": 2,
}


def drive(environment: Any) -> list[Any]:
    """A turn on the spot; the results up to the end of the episode, 12 steps at most."""
    results = [environment.reset(seed=1)]
    while len(results) <= 12 and not any(results[-1][2:4]):
        results.append(environment.step(np.array([0.0, 0.5], dtype=np.float32)))
    return results


@pytest.mark.parametrize(
    ("options", "steps"),
    [
        ({}, 12), (LIMITED, 5), (CHECKED, 12), (LIMITED | CHECKED, 5), (NOT_PLAIN, 9),
        (NOT_PLAIN | LIMITED | CHECKED, 5), ({"max_episode_steps": -1}, 12), ({"render_mode": "rgb_array_list"}, 12),
    ],
)  # fmt: skip
def test_every_option_of_make_acts_and_goes_through_a_specs_json(options: dict[str, Any], steps: int) -> None:
    environment: Any = gymnasium.make(ID, **options)
    results = drive(environment)
    assert len(results) - 1 == steps
    assert results[-1][3] == (steps < 12)
    again: Any = gymnasium.make(EnvSpec.from_json(environment.spec.to_json()))
    assert (again.spec.to_json(), str(again)) == (environment.spec.to_json(), str(environment))
    np.testing.assert_equal(drive(again), results)


@pytest.mark.parametrize(
    "wrap",
    [
        wrappers.TimeAwareObservation, wrappers.RecordEpisodeStatistics, wrappers.Autoreset, wrappers.ClipAction,
        wrappers.NormalizeObservation, wrappers.NormalizeReward, wrappers.RenderCollection, wrappers.FlattenObservation,
        wrappers.AddRenderObservation,
        lambda env: wrappers.RescaleAction(env, np.float32(-1.0), np.float32(1.0)),
        lambda env: wrappers.FrameStackObservation(env, 4), lambda env: wrappers.MaxAndSkipObservation(env, 2),
        lambda env: wrappers.DelayObservation(env, 2), lambda env: wrappers.StickyAction(env, 0.3),
        lambda env: wrappers.RescaleObservation(env, np.float32(-1.0), np.float32(1.0)),
    ],
)  # fmt: skip
def test_gymnasiums_wrappers_fit_around_a_made_environment(wrap: Callable[[Any], Any]) -> None:
    environment = wrap(gymnasium.make(ID, **LIMITED, render_mode="rgb_array", width=64, height=48))
    environment.reset(seed=0)
    observation, *_ = environment.step(environment.action_space.sample())
    assert environment.observation_space.contains(observation)
    assert environment.spec is not None
    environment.render()
    environment.close()


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
@pytest.mark.parametrize("vectorization", ["sync", "async"])
def test_a_vector_ends_and_resets_its_episodes(vectorization: str, mode: AutoresetMode) -> None:
    vector = gymnasium.make_vec(ID, 2, vectorization, {"autoreset_mode": mode}, **LIMITED)
    vector.reset(seed=0)
    results = [vector.step(np.array([[0.0, 0.5]] * 2, dtype=np.float32)) for _ in range(12)]
    vector.close()
    assert [bool(each[3].all()) for each in results[:5]] == [False] * 4 + [True]
    assert sum(bool(each[3].any()) for each in results) == 2
    assert not np.array_equal(*results[-1][0])


def test_an_id_with_its_module_is_found_in_a_process_that_imported_nothing(tmp_path: Path) -> None:
    """Gymnasium 1 reads no entry points: the module in front of the id is its own way."""
    program = f"import gymnasium; gymnasium.make('tasks:{ID}'); print(*gymnasium.registry)"
    ids = subprocess.check_output(
        [sys.executable, "-c", program], cwd=tmp_path, env={"PYTHONPATH": str(ROOT)}, text=True
    )
    assert {tasks.gymnasium_id(name) for name in tasks.ALL_TASKS} <= set(ids.split())


@pytest.mark.parametrize(("goal", "is_success"), [((1.0, 0.0), True), ((-3.0, -3.0), False)])
def test_info_has_the_same_keys_and_types_at_reset_and_at_each_step(
    goal: tuple[float, float], is_success: bool
) -> None:
    environment = gymnasium.make("asddpg/NavEmpty-v0")
    infos = [environment.reset(options={"goal": goal})[1]]
    while infos[-1]["outcome"] == "running":
        infos.append(environment.step(np.array([0.5, 0.0]))[4])
    types = [{key: type(value) for key, value in (info | info["reward_terms"]).items()} for info in infos]
    assert all(each == types[0] for each in types)
    assert [info["is_success"] for info in infos] == [False] * (len(infos) - 1) + [is_success]
    assert all((info["start"], info["goal"]) == ((0.0, 0.0, 0.0), goal) for info in infos)


def test_a_derived_reward_is_the_one_that_is_paid() -> None:
    class Fined(tasks.Reward):
        def terms(self, *arguments: Any) -> dict[str, float]:
            return super().terms(*arguments) | {"time": -100.0}

    environment = gymnasium.make(ID, reward=Fined())
    environment.reset(seed=0)
    assert float(environment.step(np.array([0.0, 0.5]))[1]) < -99.0


def test_an_episode_that_gymnasiums_limit_ends_is_a_timeout() -> None:
    still = FixedDriver(lambda _: Decision(np.zeros(2, dtype=np.float32), Driver.CONTROLLER))
    episode = run_episode(gymnasium.make(ID, **LIMITED), still)
    assert (episode.steps, episode.outcome) == (5, "timeout")
