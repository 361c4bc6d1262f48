"""Figures of an episode, counted while it goes on."""

import math
from collections.abc import Mapping
from typing import Any

from asddpg.episodes.protocols import Driver, Episode, Step


class EpisodeStats:
    """Counts the steps of one episode."""

    def __init__(self, info: Mapping[str, Any]) -> None:
        """Begin with what the environment's reset told."""
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
        """The figures so far, of an episode that ends so."""
        return Episode(outcome, self.steps, self._total_reward, self._controller_steps, self._path_length)


def _distance(before: Mapping[str, Any], after: Mapping[str, Any]) -> float:
    if "pose" not in before:
        return 0.0
    return math.dist(before["pose"][:2], after["pose"][:2])
