"""The file of a driver on a task: every episode, and under which conditions it was driven."""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from asddpg.episodes.protocols import Episode
from asddpg.errors import UserError
from asddpg.runs.run_folder import write_json
from tools.comparison.smoothness import Smoothness


@dataclass(frozen=True)
class DrivenEpisode:
    """An episode; metres, radians, world frame.

    Attributes:
        room: or task.
        start: x, y and yaw.
        goal: x and y.
        shortest_path: to within the goal's radius.
        episode: outcome, steps, return and path length.
        smoothness: of its turn rates.
        decision_ms: median CPU time of a decision, milliseconds.
    """

    room: str
    start: tuple[float, ...]
    goal: tuple[float, ...]
    shortest_path: float
    episode: Episode
    smoothness: Smoothness
    decision_ms: float

    @property
    def pair(self) -> tuple[str | float, ...]:
        """Room, start and goal, by which episodes of two drivers are paired."""
        return self.room, *self.start, *self.goal


@dataclass(frozen=True)
class DrivenCase:
    """All episodes of a driver on a task.

    Attributes:
        conditions: of the driving, as Case.conditions.
        versions: of the packages.
        decision_ms: median CPU time of a decision over all steps, milliseconds.
        episodes: in the order of the stored pairs.
    """

    conditions: Mapping[str, Any]
    versions: Mapping[str, str]
    decision_ms: float
    episodes: list[DrivenEpisode]

    @property
    def driver(self) -> str:
        """As the user names it."""
        return str(self.conditions["driver"])

    @property
    def task(self) -> str:
        """Name of the task, of the room or of the rooms."""
        return str(self.conditions.get("rooms") or self.conditions["task"]["name"])

    @property
    def control_timestep(self) -> float:
        """Seconds a step."""
        return float(self.conditions["task"]["control_timestep"])

    def split(self) -> "list[DrivenCase]":
        """The case and, where its rooms are of several generators, the part of each."""
        kinds: dict[str, list[DrivenEpisode]] = {}
        for each in self.episodes:
            kinds.setdefault(each.room.partition(":")[0], []).append(each)
        if len(kinds) == 1:
            return [self]
        parts = [(f"{self.task}, {kind}", episodes) for kind, episodes in kinds.items()]
        conditions = [dict(self.conditions) | {"rooms": task} for task, _ in parts]
        decisions = [median(each.decision_ms for each in episodes) for _, episodes in parts]
        return [
            self,
            *(
                DrivenCase(condition, self.versions, decision, episodes)
                for condition, decision, (_, episodes) in zip(conditions, decisions, parts, strict=True)
            ),
        ]

    def write(self, path: Path) -> None:
        """Write its file, whole; one of before that differs goes on as <name>_1.json and so on."""
        write_json(path, asdict(self), keeps_old=True)

    @classmethod
    def read(cls, path: Path) -> "DrivenCase":
        """Read a file; UserError where it is damaged."""
        try:
            content = json.loads(path.read_bytes())
            episodes = [_to_episode(each) for each in content.pop("episodes")]
            case = cls(**content, episodes=episodes)
            if not episodes or not (case.driver and case.task and case.control_timestep):
                raise ValueError("it is empty")
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise UserError(f"{path} is not a whole file of tools.compare; without it, it is driven again") from error
        return case


def _to_episode(content: Mapping[str, Any]) -> DrivenEpisode:
    return DrivenEpisode(
        room=content.get("room", ""),  # a file of before has one room
        start=tuple(content["start"]),
        goal=tuple(content["goal"]),
        shortest_path=content["shortest_path"],
        episode=Episode(**content["episode"]),
        smoothness=Smoothness(**content["smoothness"]),
        decision_ms=content["decision_ms"],
    )
