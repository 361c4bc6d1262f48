"""A global planner that leads any local driver: its goal is a point of the path some way ahead."""

from collections.abc import Mapping

import numpy as np

from asddpg.episodes.protocols import Agent, Decision, Observation, Step
from asddpg.planning.global_planner import Point, point_ahead
from asddpg.planning.navigator import Navigator, NavigatorOptions
from asddpg.planning.robot import Reading, Robot


class WaypointDriver:
    """Drives by a local driver, a policy or a controller, towards waypoints, the paper's setting in a real room."""

    def __init__(
        self, robot: Robot, local: Agent, look_ahead: float = 1.0, navigator: NavigatorOptions | None = None
    ) -> None:
        """Lead a driver.

        Args:
            robot: what it drives.
            local: decides by the flat observation, whose last two numbers are its goal in the robot's frame.
            look_ahead: metres along the path from the robot to the waypoint.
            navigator: how to plan.
        """
        self._robot, self._local, self._look_ahead = robot, local, look_ahead
        self._options = navigator or NavigatorOptions()
        self.navigator: Navigator | None = None

    def begin_episode(self) -> None:
        """Forget the last episode's map and plan."""
        self.navigator = None
        self._local.begin_episode()

    def decide(self, observation: Observation) -> Decision:
        """What the local driver decides with the waypoint as its goal."""
        reading = self._robot.read(observation)
        if self.navigator is None:
            self.navigator = Navigator(self._robot, self._options, reading)
        self.navigator.update(reading)
        path = self.navigator.path
        waypoint = reading.goal if path is None else point_ahead(path, reading.pose[:2], self._look_ahead)
        return self._local.decide(with_goal(observation, reading, waypoint))

    def learn(self, step: Step) -> Mapping[str, float]:
        """The local driver learns nothing here: its goals are not the task's."""
        return {}


def with_goal(observation: Observation, reading: Reading, goal: Point) -> Observation:
    """The flat observation with another goal (m, map frame): its last two numbers are x and y in the robot's frame."""
    x, y, yaw = reading.pose
    dx, dy = goal[0] - x, goal[1] - y
    changed = observation.copy()
    changed[-2:] = np.cos(yaw) * dx + np.sin(yaw) * dy, np.cos(yaw) * dy - np.sin(yaw) * dx
    return changed
