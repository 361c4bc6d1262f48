"""Switching drivers and moving the goal within an episode."""

from collections.abc import Callable, Mapping

from asddpg.episodes.protocols import Agent, Decision, Observation, Step


class SteeredDriver:
    """Drives by one of several drivers, named in `drivers`; driver and goal may change between two steps."""

    def __init__(
        self, move_goal: Callable[[float, float], Observation], drivers: Mapping[str, Agent], driver: str
    ) -> None:
        """Begin with a driver; `move_goal` moves the environment's goal and returns the present observation with it."""
        self._move_goal, self._drivers = move_goal, drivers
        self.drivers, self.driver = tuple(drivers), driver
        self._moved: Observation | None = None  # the present observation, if the goal has been moved since

    @property
    def current(self) -> Agent:
        """The driver that drives now."""
        return self._drivers[self.driver]

    def set_goal(self, x: float, y: float) -> None:
        """Another goal for the episode in progress, metres, world frame; what the environment refuses it raises."""
        self._moved = self._move_goal(x, y)

    def begin_episode(self) -> None:
        """The goal is the episode's own."""
        self._moved = None
        for driver in self._drivers.values():
            driver.begin_episode()

    def decide(self, observation: Observation) -> Decision:
        """As the present driver does, towards the present goal."""
        moved, self._moved = self._moved, None
        return self.current.decide(observation if moved is None else moved)

    def learn(self, step: Step) -> Mapping[str, float]:
        """Nothing."""
        return {}
