"""Drivers as a user writes them."""

import numpy as np

from asddpg.episodes.protocols import Action, Observation
from asddpg.planning.robot import Robot


class Forward:
    """Drives straight ahead."""

    def __init__(self, robot: Robot) -> None:
        self._speed = robot.shape.high[0]

    def act(self, observation: Observation) -> Action:
        """Full speed, no turn."""
        return np.array([self._speed, 0.0], dtype=np.float32)


class Broken(Forward):
    """Gives three numbers."""

    def act(self, observation: Observation) -> Action:
        """One too many."""
        return np.zeros(3, dtype=np.float32)


class Fragile(Forward):
    """Ends its process."""

    def act(self, observation: Observation) -> Action:
        """Nothing."""
        raise SystemExit(7)
