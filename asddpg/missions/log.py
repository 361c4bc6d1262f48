"""What happened on a mission: places, estimates, touches, and why it failed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, SupportsFloat

import numpy as np

from asddpg.episodes.protocols import Episode, Observation, Observer, Step
from asddpg.missions.environment import Mission
from asddpg.planning.occupancy_grid import FloatArray
from asddpg.planning.poses import wrap_angle

BELIEVED_BEYOND = 0.2  # m beyond `within`: a target that the robot is farther from than this was not reached
LOST_BEYOND = 0.5  # m from the estimate to the true pose


@dataclass
class MissionLog(Observer):
    """Observes a mission.

    Attributes:
        mission: where it goes.
        poses: true ones, x, y (m) and yaw (rad), at the beginning and after each step.
        estimates: the robot's own, likewise.
        arrivals: true distances (m) to the targets when the robot believed that it had reached them.
        touched: names of what it touched, each once.
        outcome: reached, crashed, timeout or cut.
    """

    mission: Mission
    poses: list[tuple[float, float, float]] = field(default_factory=list)
    estimates: list[tuple[float, float, float]] = field(default_factory=list)
    arrivals: list[float] = field(default_factory=list)
    touched: dict[str, None] = field(default_factory=dict)
    outcome: str = "cut"
    last_distance: float = math.nan  # m, from the true place to the last target driven to

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Note the start."""
        self._take(info)

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Note a step."""
        info = step.info
        self._take(info)
        self.touched |= dict.fromkeys(info["touched"])
        if info["target"] > len(self.arrivals):
            self.arrivals.append(self._distance_to_target(info))

    def end_episode(self, episode: Episode) -> None:
        """Note how it ended."""
        self.outcome = episode.outcome

    def _take(self, info: Mapping[str, Any]) -> None:
        self.poses.append(tuple(info["pose"]))
        self.estimates.append(tuple(info["estimate"]))

    def _distance_to_target(self, info: Mapping[str, Any]) -> float:
        return math.dist(info["pose"][:2], self.mission.targets[len(self.arrivals)])

    @property
    def errors(self) -> FloatArray:
        """Distances from estimate to true place, (steps + 1,), metres."""
        return np.asarray(np.hypot(*(np.array(self.estimates) - np.array(self.poses))[:, :2].T))

    @property
    def heading_errors(self) -> FloatArray:
        """Errors of the heading, (steps + 1,), rad, not negative."""
        return np.abs(wrap_angle((np.array(self.estimates) - np.array(self.poses))[:, 2]))

    @property
    def path_length(self) -> float:
        """Metres driven."""
        return float(np.hypot(*np.diff(np.array(self.poses)[:, :2], axis=0).T).sum())

    def failure(self, within: float, unmapped: tuple[str, ...]) -> str:
        """Why the mission failed, or nothing: every target reached in truth, and nothing touched.

        Args:
            within: metres from a target that count as reached.
            unmapped: obstacles that the map lacks.
        """
        number = len(self.arrivals) + 1
        if self.touched:
            return self._describe_touch(unmapped, number)
        if self.outcome != "reached":
            return f"target {number} not reached in time"
        missed = [index for index, off in enumerate(self.arrivals, 1) if off > within + BELIEVED_BEYOND]
        return f"target {missed[0]} missed by {self.arrivals[missed[0] - 1]:.2f} m" if missed else ""

    def _describe_touch(self, unmapped: tuple[str, ...], number: int) -> str:
        name = next(iter(self.touched))
        lacks = ", not on the map" if any(name == each or name.startswith(f"{each}_") for each in unmapped) else ""
        lost = f", {self.errors[-1]:.2f} m from where it believed to be" if self.errors[-1] > LOST_BEYOND else ""
        return f"touched {name}{lacks}{lost}, on the way to target {number}"
