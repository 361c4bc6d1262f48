"""Statistics of an episode, updated step by step."""

import math
from collections.abc import Mapping
from typing import Any

from asddpg.episodes.protocols import Driver, Episode, Step


class EpisodeStats:
    """Counts the steps of one episode; adds up reward and path length."""

    def __init__(self, info: Mapping[str, Any]) -> None:
        """Start from the info of the environment's reset, or of the instant at which the episode is resumed."""
        self.steps = 0
        self._total_reward, self._controller_steps, self._path_length = 0.0, 0, 0.0
        self._info = info

    def add(self, step: Step) -> None:
        """Count a step."""
        self.steps += 1
        self._total_reward += step.reward
        self._controller_steps += step.decision.driver is Driver.CONTROLLER
        self._path_length += _distance(self._info, step.info)
        self._info = step.info

    def episode(self, outcome: str) -> Episode:
        """The statistics so far, of an episode that ends with this outcome."""
        return Episode(outcome, self.steps, self._total_reward, self._controller_steps, self._path_length)

    def state(self) -> dict[str, Any]:
        """The sums so far."""
        return {
            "steps": self.steps,
            "total_reward": self._total_reward,
            "controller_steps": self._controller_steps,
            "path_length": self._path_length,
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned."""
        self.steps, self._total_reward = state["steps"], state["total_reward"]
        self._controller_steps, self._path_length = state["controller_steps"], state["path_length"]


def _distance(before: Mapping[str, Any], after: Mapping[str, Any]) -> float:
    if "pose" not in before:
        return 0.0
    return math.dist(before["pose"][:2], after["pose"][:2])
