"""Episodes of a fixed driver, step by step, and the critics' values of their states."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, SupportsFloat

import gymnasium
import numpy as np
import numpy.typing as npt
import torch

from asddpg.algorithm.agent import AsDDPG
from asddpg.algorithm.networks import CONTROLLER, POLICY
from asddpg.algorithm.reward_shaping import assisted_reward
from asddpg.config import LearningConfig
from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.evaluation import StartGoalPair
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Driver, Episode, Observation, Step

FloatArray = npt.NDArray[np.float64]
Float32Array = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Rollout:
    """An episode.

    Attributes:
        outcome: reached, crashed or timeout.
        goal: metres, world frame.
        places: of the robot before each step and after the last, (steps + 1, 2), metres, world frame.
        observations: before each step, float32 (steps, observation_size).
        actions: executed, (steps, 2), m/s and rad/s.
        by_controller: whether the controller drove, (steps,).
        rewards: as the switch learns them, less the price of the controller's steps, (steps,).
    """

    outcome: str
    goal: tuple[float, float]
    places: FloatArray
    observations: Float32Array
    actions: FloatArray
    by_controller: npt.NDArray[np.bool_]
    rewards: FloatArray


class RolloutRecorder:
    """Observer that records one episode as a Rollout."""

    def __init__(self, goal: tuple[float, float], reward: Callable[[Step], float]) -> None:
        """Record an episode to `goal` (m); `reward` gives the reward of a step."""
        self._goal, self._reward = goal, reward
        self._places: list[tuple[float, float]] = []
        self._steps: list[Step] = []
        self._outcome = ""

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Record the start."""
        self._places.append(info["pose"][:2])

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Record a step."""
        self._steps.append(step)
        self._places.append(step.info["pose"][:2])

    def end_episode(self, episode: Episode) -> None:
        """Record the outcome."""
        self._outcome = episode.outcome

    def rollout(self) -> Rollout:
        """The recorded episode."""
        decisions = [step.decision for step in self._steps]
        return Rollout(
            outcome=self._outcome,
            goal=self._goal,
            places=np.array(self._places, dtype=np.float64),
            observations=np.array([step.observation for step in self._steps]),
            actions=np.array([decision.action for decision in decisions], dtype=np.float64),
            by_controller=np.array([decision.driver is Driver.CONTROLLER for decision in decisions]),
            rewards=np.array([self._reward(step) for step in self._steps], dtype=np.float64),
        )


def drive(
    environment: gymnasium.Env, driver: FixedDriver, pairs: Sequence[StartGoalPair], config: LearningConfig
) -> list[Rollout]:
    """Drive one episode for each pair; `config` has the price of the controller's steps."""

    def charged(step: Step) -> float:
        return assisted_reward(
            step.reward, step.info["dense_reward"], step.decision.driver, config.gamma_p, config.controller_price
        )

    environment.reset(seed=0)  # of the laser's noise, where it has any
    recorders = [RolloutRecorder(pair.goal, charged) for pair in pairs]
    for pair, recorder in zip(pairs, recorders, strict=True):
        run_episode(environment, driver, (recorder,), options={"start": pair.start, "goal": pair.goal})
    return [recorder.rollout() for recorder in recorders]


class Values(NamedTuple):
    """The critics' values of states, each (states,); without a switch there is Q^A alone."""

    actor: FloatArray  # Q^A(x, π(x))
    policy: FloatArray | None  # Q(x, σ = policy)
    controller: FloatArray | None  # Q(x, σ = controller)


@torch.no_grad()
def critic_values(agent: AsDDPG, rollouts: Sequence[Rollout]) -> Values:
    """The values of all states of some episodes, one episode after the other."""
    x = torch.from_numpy(np.concatenate([rollout.observations for rollout in rollouts])).to(agent.device)
    networks = agent.networks
    features = networks.features(x)
    actor = _array(networks.critic(features, networks.policy(x)))
    if networks.switch is None:
        return Values(actor, None, None)
    q = networks.switch(features)
    return Values(actor, _array(q[:, POLICY]), _array(q[:, CONTROLLER]))


def _array(values: torch.Tensor) -> FloatArray:
    return values.double().cpu().numpy()
