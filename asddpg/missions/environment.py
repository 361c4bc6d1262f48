"""An environment whose episode is a mission: targets in turn, each reached where the robot believes it is there."""

import math
from collections import deque
from typing import Any, NamedTuple

import numpy as np

from asddpg.drivers.localized_robot import LocalizedRobot
from asddpg.episodes.protocols import Observation
from asddpg.planning.waypoints import with_goal
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.navigation import clip_goal
from tasks.rewards import Outcome

Point = tuple[float, float]


class Mission(NamedTuple):
    """Where a mission begins and leads.

    Attributes:
        start: x, y (m) and yaw (rad), map frame.
        targets: in turn, x and y, metres, map frame.
        seed: of the laser's noise and of the particles, so that a mission does not depend on those before it.
    """

    start: tuple[float, float, float]
    targets: tuple[Point, ...]
    seed: int


class MissionEnvironment:
    """Observations have the present target as their goal, in the frame of the robot's own estimate of its pose.

    `info` is that of the environment below, and `estimate` (x, y, yaw; m, rad), `target`, the number of targets
    reached, and `touched`, names of what the robot touches. `outcome` is reached after the last target.
    """

    def __init__(self, environment: NavigationEnv, robot: LocalizedRobot, within: float, patience: float) -> None:
        """Make missions of an environment that ends no episode at its goal or by its time limit.

        Args:
            environment: what drives.
            robot: reads it.
            within: metres from a target that count as reached.
            patience: seconds for each target.
        """
        self._environment, self._robot, self._within = environment, robot, within
        self._steps_a_target = max(1, round(patience / environment.task.config.control_timestep))
        self._waiting: deque[Point] = deque()
        self._outcome = Outcome.TIMEOUT  # until the first mission

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin the mission of `options["mission"]`."""
        assert options is not None
        mission: Mission = options["mission"]
        first, *others = mission.targets
        self._waiting, self._reached, self._steps_left = deque(others), 0, self._steps_a_target
        options = {"start": mission.start, "goal": first}
        observation, info = self._environment.reset(seed=mission.seed, options=options)
        self._robot.amcl.rng = np.random.default_rng(mission.seed)
        self._robot.begin(observation, info["pose"])
        return self._to_estimate(observation), self._extend(info, Outcome.RUNNING)

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for one control step, and go on to the next target where the present one is reached."""
        observation, reward, terminated, truncated, info = self._environment.step(action)
        reading = self._robot.read(observation)
        self._steps_left -= 1
        outcome = Outcome(info["outcome"])
        if outcome is Outcome.RUNNING and math.dist(reading.pose[:2], reading.goal) <= self._within:
            self._reached += 1
            if self._waiting:
                observation = self._environment.set_goal(*self._waiting.popleft())
                self._steps_left = self._steps_a_target
            else:
                outcome, terminated = Outcome.REACHED, True
        elif outcome is Outcome.RUNNING and self._steps_left <= 0:
            outcome, truncated = Outcome.TIMEOUT, True
        return self._to_estimate(observation), reward, terminated, truncated, self._extend(info, outcome)

    def set_goal(self, x: float, y: float) -> Observation:
        """Another place for the present target, metres, map frame.

        Raises:
            TaskError: it is not free, or the mission is over.
        """
        if self._outcome is not Outcome.RUNNING:
            raise TaskError("no mission is in progress whose target could be moved")
        observation = self._environment.set_goal(x, y)
        self._steps_left = self._steps_a_target
        return self._to_estimate(observation)

    def _to_estimate(self, observation: Observation) -> Observation:
        """The observation as the robot knows it: its goal is seen from the estimated pose, not from the true one."""
        reading = self._robot.read(observation)
        seen = with_goal(observation, reading, reading.goal)
        x, y = seen[-2:].tolist()
        seen[-2:] = clip_goal((x, y), self._environment.task.config.goal_range)
        return seen

    def _extend(self, info: dict[str, Any], outcome: Outcome) -> dict[str, Any]:
        self._outcome = outcome
        return info | {
            "outcome": str(outcome),
            "is_success": outcome is Outcome.REACHED,
            "estimate": self._robot.reading.pose,
            "target": self._reached,
            "touched": self._environment.physics.touched(),
        }
