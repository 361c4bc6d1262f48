"""Episodes of a fixed driver, step by step, and the critics' values of their states."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, SupportsFloat

import gymnasium
import numpy as np
import numpy.typing as npt
import torch

from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.networks import CONTROLLER, POLICY
from asddpg.algorithm.reward_shaping import assisted_rewards
from asddpg.config import AgentConfig
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.evaluation import StartGoalPair
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Driver, Observation, Observer, Step
from tasks.physics import FloatArray


@dataclass(frozen=True)
class Rollout:
    """An episode; places in metres, world frame."""

    outcome: str  # reached, crashed or timeout
    goal: tuple[float, float]
    places: FloatArray  # of the robot before each step and after the last, (steps + 1, 2)
    observations: npt.NDArray[np.float32]  # before each step, (steps, observation_size)
    actions: FloatArray  # executed, (steps, 2), m/s and rad/s
    by_controller: npt.NDArray[np.bool_]  # whether the controller drove, (steps,)
    rewards: FloatArray  # as the switch learns them, less the price of the controller's steps, (steps,)


class _StepRecorder(Observer):
    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        self.steps: list[Step] = []
        self.places: list[tuple[float, float]] = [info["pose"][:2]]

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        self.steps.append(step)
        self.places.append(step.info["pose"][:2])


def drive(
    environment: gymnasium.Env, driver: FixedDriver, pairs: Sequence[StartGoalPair], config: AgentConfig
) -> list[Rollout]:
    """Drive one episode for each pair; `config` has the price of the controller's steps."""
    environment.reset(seed=0)  # of the laser's noise, where it has any
    return [_drive_pair(environment, driver, pair, config) for pair in pairs]


def _drive_pair(environment: gymnasium.Env, driver: FixedDriver, pair: StartGoalPair, config: AgentConfig) -> Rollout:
    recorder = _StepRecorder()
    episode = run_episode(environment, driver, (recorder,), options=pair.reset_options)
    steps = [(step, step.decision) for step in recorder.steps]
    by_controller = np.array([decision.driver is Driver.CONTROLLER for _, decision in steps])
    rewards, dense_rewards = np.array([(step.reward, step.info["dense_reward"]) for step, _ in steps]).T
    return Rollout(
        outcome=episode.outcome,
        goal=pair.goal,
        places=np.array(recorder.places, dtype=np.float64),
        observations=np.array([step.observation for step, _ in steps]),
        actions=np.array([decision.action for _, decision in steps], dtype=np.float64),
        by_controller=by_controller,
        rewards=assisted_rewards(rewards, dense_rewards, by_controller, config.gamma_p, config.controller_price),
    )


@torch.no_grad()
def critic_values(agent: AsDDPG, rollouts: Sequence[Rollout]) -> dict[str, FloatArray]:
    """The critics' values of all states of some episodes, one episode after the other, each (states,).

    By name: actor for Q^A(x, π(x)); with a switch also policy for Q(x, σ = policy) and controller for
    Q(x, σ = controller).
    """
    networks = agent.networks
    device = next(networks.parameters()).device
    x = torch.from_numpy(np.concatenate([rollout.observations for rollout in rollouts])).to(device)
    features = networks.features(x)
    values = {"actor": networks.critic(features, networks.policy(x))}
    if networks.switch is not None:
        q = networks.switch(features)
        values |= {"policy": q[:, POLICY], "controller": q[:, CONTROLLER]}
    return {name: value.double().cpu().numpy() for name, value in values.items()}
