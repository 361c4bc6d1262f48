"""Statistics of episodes that robots drive side by side."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from asddpg.episodes.batch_steps import Infos, IntArray, Steps
from asddpg.episodes.protocols import Episode


class EpisodeSums:
    """Steps, rewards and ways of the episodes in progress, a row for each robot."""

    def __init__(self, robots: int) -> None:
        self._sums: dict[str, Any] = {
            "steps": np.zeros(robots, np.int64),
            "total_reward": np.zeros(robots),
            "controller_steps": np.zeros(robots, np.int64),
            "path_length": np.zeros(robots),
        }

    def reset(self, robots: IntArray) -> None:
        """Begin anew for these robots."""
        for values in self._sums.values():
            values[robots] = 0

    def add(self, steps: Steps, previous_infos: Infos) -> None:
        """Add a step of every robot; `previous_infos` are those of the instant before it."""
        self._sums["steps"] += 1
        self._sums["total_reward"] += steps.rewards
        self._sums["controller_steps"] += steps.decisions.by_controller
        if "pose" in previous_infos:
            before, after = previous_infos["pose"][:, :2].tolist(), steps.infos["pose"][:, :2].tolist()
            self._sums["path_length"] += [*map(math.dist, before, after)]

    def episode(self, robot: int, outcome: str) -> Episode:
        """The statistics of a robot's episode, which has ended so."""
        return Episode(outcome, **{name: values[robot].item() for name, values in self._sums.items()})

    def state(self) -> dict[str, Any]:
        """The sums by name."""
        return {name: values.copy() for name, values in self._sums.items()}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore what state() returned."""
        self._sums = {name: state[name].copy() for name in self._sums}


def outcome_of(steps: Steps, robot: int) -> str:
    """How the episode of a robot ended that is terminated or truncated."""
    outcome = str(steps.infos["outcome"][robot]) if "outcome" in steps.infos else "running"
    if outcome != "running":
        return outcome
    return "ended" if steps.terminated[robot] else "timeout"
