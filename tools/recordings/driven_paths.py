"""Paths that recorded episodes drove."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tasks.physics import FloatArray
from tools.recordings.episode_states import EpisodeStates


@dataclass(frozen=True)
class DrivenPath:
    """An episode as a map shows it.

    Attributes:
        number: of the episode.
        places: (n + 1, 2), of the base after each of n steps, metres, world frame.
        yaw: of the base at the beginning, rad.
        drivers: n names, a step each.
        goal: x, y, m.
        goal_radius: m.
        outcome: how it ended.
        seconds: simulated.
    """

    number: int
    places: FloatArray
    yaw: float
    drivers: Sequence[str]
    goal: tuple[float, float]
    goal_radius: float
    outcome: str
    seconds: float

    def length(self) -> float:
        """Metres driven."""
        return float(np.hypot(*np.diff(self.places, axis=0).T).sum())

    def stretches(self) -> list[tuple[str, FloatArray]]:
        """The path cut where the driver changed: the driver, and the places from first to last, (m, 2)."""
        return [(driver, self.places[begin : end + 1]) for driver, begin, end in driver_runs(self.drivers)]


def driver_runs(drivers: Sequence[str]) -> list[tuple[str, int, int]]:
    """Runs of steps with one driver: its name, the first step, and the step after the last."""
    changes = [index for index, (before, after) in enumerate(pairwise(drivers), 1) if before != after]
    bounds = [0, *changes, len(drivers)]
    return [(drivers[begin], begin, end) for begin, end in pairwise(bounds) if end > begin]


def read_path(states: EpisodeStates) -> DrivenPath:
    """The path of an episode, run to its end."""
    places = [states.physics.pose()[:2] for _ in states]
    return DrivenPath(
        number=int(states.recording.facts["episode"]),
        places=np.array(places),
        yaw=states.recording.start[2],
        drivers=[step["driver"] for step in states.steps],
        goal=states.recording.goal,
        goal_radius=states.config.task.goal_radius,
        outcome=states.outcome,
        seconds=states.time(len(states.steps)),
    )
