"""Numbers gone wrong are noticed in the step in which they appear."""

import math
from collections.abc import Mapping
from typing import Any, SupportsFloat

import numpy as np

from asddpg.episodes.protocols import Callback, Observation, Step

LOSSES = ("critic_loss", "switch_loss", "policy_loss")  # a TD error may be nan: of a driver who is not in the batch


class NotFiniteError(Exception):
    """A number of a training is NaN or infinite; the message says which."""


class FiniteCheck(Callback):
    """Watches, and ends a training by an exception where a number is NaN or infinite."""

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Look at the first observation."""
        _check("the observation", observation)

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Look at what was decided, seen, earned and learned."""
        _check("the action", step.decision.action)
        _check("the observation", step.next_observation)
        if not math.isfinite(step.reward):
            raise NotFiniteError(f"the reward is {step.reward}")
        for name in LOSSES:
            if name in learned and not math.isfinite(value := float(learned[name])):
                raise NotFiniteError(f"{name} is {value}")


def _check(name: str, numbers: Observation) -> None:
    if not np.isfinite(numbers).all():
        raise NotFiniteError(f"{name} holds {numbers[~np.isfinite(numbers)][0]}")
