"""Drivers that do not learn: the actor alone, the switched policy, and the baselines."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from asddpg.episodes.protocols import Action, Controller, Decision, Driver, Observation, Step


class FixedDriver:
    """Drives by a fixed rule and learns nothing; FixedDriver(agent.decide_greedily) is the switched policy."""

    def __init__(self, decide: Callable[[Observation], Decision]) -> None:
        self._decide = decide

    def begin_episode(self) -> None:
        """A fixed rule has no state to reset."""

    def decide(self, observation: Observation) -> Decision:
        """Decide by the rule."""
        return self._decide(observation)

    def learn(self, step: Step) -> Mapping[str, float]:
        """A fixed rule learns nothing."""
        return {}


def actor_alone(policy: Controller) -> FixedDriver:
    """The policy of a trained agent without noise, switch or controller: what a user deploys."""

    def decide(observation: Observation) -> Decision:
        action = policy.act(observation)
        return Decision(action, Driver.POLICY, actor_action=action)

    return FixedDriver(decide)


def controller_alone(controller: Controller) -> FixedDriver:
    """The controller as a baseline."""

    def decide(observation: Observation) -> Decision:
        action = controller.act(observation)
        return Decision(action, Driver.CONTROLLER, controller_action=action)

    return FixedDriver(decide)


def with_values(driver: FixedDriver, values: Callable[[Observation], Mapping[str, Any]]) -> FixedDriver:
    """The same driver, its decisions with a switch's q_policy, q_controller and value, for recordings."""
    return FixedDriver(lambda observation: replace(driver.decide(observation), **values(observation)))


def random_actor(low: Action, high: Action, rng: np.random.Generator) -> FixedDriver:
    """Uniformly random actions as a baseline."""

    def decide(_: Observation) -> Decision:
        return Decision(rng.uniform(low, high).astype(np.float32), Driver.RANDOM)

    return FixedDriver(decide)
