"""Switching drivers and moving the goal within an episode."""

from collections.abc import Mapping
from typing import Protocol

from asddpg.episodes.drivers import FixedDriver
from asddpg.episodes.protocols import Decision, Observation, Step


class GoalSetter(Protocol):
    """The part of NavigationEnv that is used."""

    def set_goal(self, x: float, y: float) -> Observation:
        """Move the goal; returns the present observation with it."""


class SteeredDriver:
    """Drives by one of several drivers, named in `drivers`; driver and goal may change between two steps."""

    def __init__(self, environment: GoalSetter, drivers: Mapping[str, FixedDriver], driver: str) -> None:
        self._environment, self._drivers = environment, drivers
        self.drivers, self.driver = tuple(drivers), driver
        self._moved: Observation | None = None  # the present observation, if the goal has been moved since

    def set_goal(self, x: float, y: float) -> None:
        """Another goal for the episode in progress, metres, world frame; what the environment refuses it raises."""
        self._moved = self._environment.set_goal(x, y)

    def begin_episode(self) -> None:
        """The goal is the episode's own."""
        self._moved = None

    def decide(self, observation: Observation) -> Decision:
        """As the present driver does, towards the present goal."""
        moved, self._moved = self._moved, None
        return self._drivers[self.driver].decide(observation if moved is None else moved)

    def learn(self, step: Step) -> Mapping[str, float]:
        """Nothing."""
        return {}
