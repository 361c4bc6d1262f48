"""What happened on a mission: places, estimates, touches, and why it failed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, SupportsFloat

import numpy as np

from asddpg.episodes.protocols import Episode, Observation, Observer, Step
from asddpg.missions.environment import Mission
from asddpg.planning.occupancy_grid import FloatArray
from asddpg.planning.poses import wrap_angle

BELIEVED_BEYOND = 0.2  # m beyond `within`: a target that the robot is farther from than this was not reached
LOST_BEYOND = 0.5  # m from the estimate to the true pose


class Touch(NamedTuple):
    """The first touch of a thing.

    Attributes:
        name: of the thing.
        target: number of the target driven to, from 1.
        step: index among the poses.
    """

    name: str
    target: int
    step: int


@dataclass
class MissionLog(Observer):
    """Observes a mission.

    Attributes:
        mission: where it goes.
        targets: x and y, metres, map frame; a viewer may have moved one on the way to it.
        poses: true ones, x, y (m) and yaw (rad), at the beginning and after each step.
        estimates: the robot's own, likewise.
        arrivals: true distances (m) to the targets when the robot believed that it had reached them.
        touches: what it touched, each thing once.
        outcome: reached, crashed, timeout or cut.
    """

    mission: Mission
    poses: list[tuple[float, float, float]] = field(default_factory=list)
    estimates: list[tuple[float, float, float]] = field(default_factory=list)
    arrivals: list[float] = field(default_factory=list)
    touches: list[Touch] = field(default_factory=list)
    outcome: str = "cut"

    def __post_init__(self) -> None:
        """Nothing has moved yet."""
        self.targets = list(self.mission.targets)

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Note the start."""
        self._take(info)

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Note a step."""
        info = step.info
        self._take(info)
        number = len(self.arrivals) + 1
        self.targets[number - 1] = info["goal"]
        known = {touch.name for touch in self.touches}
        self.touches += [Touch(name, number, len(self.poses) - 1) for name in info["touched"] if name not in known]
        if info["target"] >= number:
            self.arrivals.append(info["distance"])

    def end_episode(self, episode: Episode) -> None:
        """Note how it ended."""
        self.outcome = episode.outcome

    def _take(self, info: Mapping[str, Any]) -> None:
        self.poses.append(tuple(info["pose"]))
        self.estimates.append(tuple(info["estimate"]))

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
        if self.touches:
            return self._describe_touch(self.touches[0], unmapped)
        if self.outcome != "reached":
            return f"target {len(self.arrivals) + 1} not reached in time"
        missed = [index for index, off in enumerate(self.arrivals, 1) if off > within + BELIEVED_BEYOND]
        return f"target {missed[0]} missed by {self.arrivals[missed[0] - 1]:.2f} m" if missed else ""

    def _describe_touch(self, touch: Touch, unmapped: tuple[str, ...]) -> str:
        name, error = touch.name, self.errors[touch.step]
        lacks = ", not on the map" if any(name == each or name.startswith(f"{each}_") for each in unmapped) else ""
        lost = f", {error:.2f} m from where it believed to be" if error > LOST_BEYOND else ""
        return f"touched {name}{lacks}{lost}, on the way to target {touch.target}"
