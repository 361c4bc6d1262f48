"""A policy in SI units drives as it does in the simulator."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from asddpg import train
from asddpg.build import make_environment, prepare_torch
from asddpg.config import EvaluateConfig
from asddpg.deployment import SIPolicy, load_policy
from asddpg.drivers.driver_setup import set_up_driver
from asddpg.errors import UserError
from asddpg.runs.run_folder import RunFolder, read_training
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tests.conftest import TINY

SHIPPED = "pretrained:nav_complex"


def read(environment: NavigationEnv) -> dict[str, Any]:
    """What a robot knows, with infinity where there is no return."""
    physics, readings = environment.physics, environment.task.readings
    ranges = physics.ranges()
    return {
        "ranges": np.where(ranges < physics.max_range, ranges, np.inf),
        "angles": environment.task.config.laser.ring.angles(),
        "velocity": readings.velocity.linear,
        "turn_rate": readings.velocity.angular,
        "goal": readings.goal_in_robot_frame,
    }


@prepare_torch()
def compare(run: str, policy: SIPolicy) -> int:
    """Drive an episode by the simulator's observations; the steps, in each of which both actions were equal."""
    setup = set_up_driver(EvaluateConfig(run=run), "evaluate", 0)
    environment, driver = setup.environment, setup.drivers["actor"]
    inner: Any = environment.unwrapped
    observation, _ = environment.reset(seed=3)
    policy.reset()
    for step in range(1, 201):
        action = driver.decide(observation).action
        assert policy.act(**read(inner)) == tuple(action.tolist())
        observation, _, terminated, truncated, _ = environment.step(action)
        if terminated or truncated:
            return step
    raise AssertionError("the episode has no end")


def test_its_actions_are_those_in_the_simulator_to_the_last_bit() -> None:
    policy = load_policy(SHIPPED)
    assert compare(SHIPPED, policy) > 20
    assert compare(SHIPPED, policy) > 20  # after a reset


def test_a_run_is_loaded_by_its_folder(tiny_run: Path) -> None:
    assert compare(str(tiny_run), load_policy(str(tiny_run))) > 0


def test_a_policy_of_several_rays_a_beam_and_near_goals_drives_as_in_the_simulator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    options = ["task.laser.rays_per_beam=3", "task.goal_range=1.5", "run_dir=run"]
    train.main(["task=nav_complex", *TINY, "total_steps=120", *options])
    assert compare("run", load_policy("run")) > 0


@pytest.mark.parametrize(
    "laser",
    [
        {"num_beams": 1081, "field_of_view": 270.0, "max_range": 10.0},
        {"num_beams": 360, "field_of_view": 360.0, "max_range": 5.6},
    ],
    ids=str,
)
def test_a_shipped_policy_reaches_its_goals_by_other_lasers(laser: dict[str, Any]) -> None:
    policy = load_policy(SHIPPED)
    config = dataclasses.replace(policy.config.task, laser=dataclasses.replace(policy.config.task.laser, **laser))
    environment: Any = make_environment(config, policy.config.reward)
    for seed in range(3):
        environment.reset(seed=seed)
        policy.reset()
        over, info = False, {}
        while not over:
            *_, terminated, truncated, info = environment.step(np.array(policy.act(**read(environment.unwrapped))))
            over = terminated or truncated
        assert info["outcome"] == "reached"


def test_the_scans_before_count_until_a_reset() -> None:
    policy, angles = load_policy(SHIPPED), np.radians(np.arange(-120, 121))
    arguments: dict[str, Any] = {"angles": angles, "velocity": 0.3, "turn_rate": 0.0, "goal": (2.0, 0.5)}
    first = policy.act(ranges=np.full(241, 2.0), **arguments)
    assert policy.act(ranges=np.full(241, 1.0), **arguments) != policy.act(ranges=np.full(241, 1.0), **arguments)
    policy.reset()
    assert policy.act(ranges=np.full(241, 2.0), **arguments) == first
    assert all(type(number) is float for number in first)


def test_numbers_that_are_no_measurement_are_refused_and_change_nothing() -> None:
    policy, angles = load_policy(SHIPPED), np.radians(np.arange(-120, 121))
    good: dict[str, Any] = {
        "ranges": np.full(241, 2.0),
        "angles": angles,
        "velocity": 0.3,
        "turn_rate": 0.0,
        "goal": (2.0, 0.5),
    }
    policy.act(**good)
    expected = policy.act(**good | {"velocity": 0.2})
    policy.reset()
    policy.act(**good)
    for name, value in (("velocity", math.nan), ("turn_rate", math.inf), ("goal", (1.0, math.nan)), ("goal", (1.0,))):
        with pytest.raises(UserError, match="must be finite numbers"):
            policy.act(**good | {name: value})
    with pytest.raises(UserError, match="lacks 8 of the policy's 40 beams"):
        policy.act(**good | {"ranges": np.ones(181), "angles": np.radians(np.arange(-90, 91))})
    assert policy.act(**good | {"velocity": 0.2}) == expected


def test_weights_of_another_laser_than_the_configurations_are_refused(tiny_run: Path, tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    config, provenance = read_training(RunFolder(tiny_run).config)
    run.checkpoint("last").parent.mkdir(parents=True)
    run.checkpoint("last").write_bytes(RunFolder(tiny_run).checkpoint("last").read_bytes())
    config.task.laser.num_beams += 1
    run.write_config(config, provenance)
    with pytest.raises(UserError, match="is for other scans than its config.yaml describes"):
        load_policy(str(run.path))
    with pytest.raises(UserError, match="there is no pretrained policy 'nav_moon'"):
        load_policy("pretrained:nav_moon")
