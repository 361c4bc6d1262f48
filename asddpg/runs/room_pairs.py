"""The evaluation pairs of a run in a room, kept in its folder with their shortest paths, which take long to search."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from asddpg.config import TaskConfig
from asddpg.runs.run_folder import RunFolder, write_json
from tasks.errors import TaskError
from tasks.evaluation_pairs import stored_pairs
from tasks.robots.names import PIONEER
from tasks.room_geometry.held_out import Pair, SetName, pairs_of_rows
from tasks.rooms.limits import read_bytes
from tasks.rooms.pairs import SIZES, room_digest
from tasks.rooms.reading import find_room, is_room


def keep_pairs(folder: RunFolder, task: TaskConfig) -> None:
    """Write both sets of a run's room; nothing for a task, whose sets are stored."""
    if is_room(task.name):
        sets = {name: stored_pairs(task.name, name, task.goal_radius, robot=task.robot) for name in SIZES}
        rows = {name: [vars(pair) for pair in pairs] for name, pairs in sets.items()}
        write_json(folder.pairs, _conditions(task) | rows)


def kept_pairs(run: str | None, task: TaskConfig, set_name: SetName) -> tuple[Pair, ...]:
    """The pairs that a run keeps; () where they are damaged, or not of this room and goal radius."""
    try:
        content = json.loads(read_bytes(RunFolder(Path(run or "")).pairs)) if is_room(task.name) else {}
        if _conditions(task).items() <= ({"robot": PIONEER} | content).items():
            pairs = pairs_of_rows(content[set_name])
            if all(np.isfinite([*pair.start, *pair.goal, pair.shortest_path]).all() for pair in pairs):
                return pairs
    except (TaskError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        pass
    return ()


def _conditions(task: TaskConfig) -> dict[str, Any]:
    return {"room": room_digest(find_room(task.name)), "goal_radius": task.goal_radius, "robot": task.robot}
