"""The stored evaluation sets: fixed start-goal pairs that training never sees."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tasks.physics import FloatArray, Pose

FOLDER = Path(__file__).resolve().parents[1] / "held_out"

SetName = Literal["validation", "test"]


@dataclass(frozen=True)
class Pair:
    """A start and a goal.

    Attributes:
        start: pose of the base, metres and radians, world frame.
        goal: metres, world frame.
        shortest_path: length of the shortest free path to within the goal's radius, metres.
    """

    start: Pose
    goal: tuple[float, float]
    shortest_path: float
    room: str = ""  # of nav_anywhere

    @property
    def reset_options(self) -> dict[str, Any]:
        """What an environment's reset takes to begin an episode from the start to the goal."""
        options: dict[str, Any] = {"start": self.start, "goal": self.goal}
        return options | ({"room": self.room} if self.room else {})


@cache
def held_out_pairs(task_name: str, set_name: SetName) -> tuple[Pair, ...]:
    """The stored pairs of a task: 50 for validation while training, 200 for the final test."""
    return pairs_of_rows(json.loads((FOLDER / f"{task_name}.json").read_text())[set_name])


def pairs_of_rows(rows: Sequence[Mapping[str, Any]]) -> tuple[Pair, ...]:
    """The pairs of a file's rows."""
    return tuple(
        Pair(Pose(*row["start"]), (row["goal"][0], row["goal"][1]), row["shortest_path"], row.get("room", ""))
        for row in rows
    )


@cache
def held_out_goals(task_name: str) -> FloatArray:
    """Goals of both sets, float64 (n, 2), metres; empty for a task without stored sets."""
    if not (FOLDER / f"{task_name}.json").exists():
        return np.zeros((0, 2))
    pairs = held_out_pairs(task_name, "validation") + held_out_pairs(task_name, "test")
    return np.array([pair.goal for pair in pairs])
