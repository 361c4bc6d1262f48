"""Start-goal pairs for an evaluation, drawn or stored, with the shortest paths that SPL needs."""

import dataclasses
from collections.abc import Sequence
from functools import cache

import numpy as np

from tasks.constants import GOAL_RADIUS
from tasks.goals import HALF_ROOM, draw_goal
from tasks.held_out import Pair, SetName, held_out_goals, held_out_pairs
from tasks.obstacles import Obstacles
from tasks.paths import ShortestPaths
from tasks.physics import FloatArray, Physics, Pose
from tasks.scenes import scene_path


def fresh_pairs(task_name: str, rng: np.random.Generator, count: int, goal_radius: float) -> tuple[Pair, ...]:
    """Draw pairs of a task as training does, away from the goals of the stored sets."""
    return draw_pairs(task_name, rng, count, goal_radius, held_out_goals(task_name))


def draw_pairs(
    task_name: str, rng: np.random.Generator, count: int, goal_radius: float, held_out: FloatArray
) -> tuple[Pair, ...]:
    """Draw pairs, no goal within HELD_OUT_MARGIN of those held out, (n, 2) metres."""
    obstacles = _obstacles(task_name)
    goals = np.round([draw_goal(rng, obstacles, held_out) for _ in range(count)], 3)
    start = Pose(0.0, 0.0, 0.0)
    return _with_paths([Pair(start, (float(x), float(y)), np.inf) for x, y in goals], obstacles, goal_radius)


@cache
def stored_pairs(task_name: str, set_name: SetName, goal_radius: float) -> tuple[Pair, ...]:
    """The stored pairs of a task; for another radius than the task's own their shortest paths are computed anew."""
    pairs = held_out_pairs(task_name, set_name)
    return pairs if goal_radius == GOAL_RADIUS else _with_paths(pairs, _obstacles(task_name), goal_radius)


def _obstacles(task_name: str) -> Obstacles:
    return Obstacles.from_model(Physics.from_xml_path(str(scene_path(task_name))).model.ptr)


def _with_paths(pairs: Sequence[Pair], obstacles: Obstacles, goal_radius: float) -> tuple[Pair, ...]:
    """The pairs, all of which start at the origin, with the lengths of their shortest paths."""
    goals = np.array([pair.goal for pair in pairs])
    lengths = ShortestPaths(obstacles, HALF_ROOM).lengths((0.0, 0.0), goals, goal_radius).round(3).tolist()
    return tuple(dataclasses.replace(pair, shortest_path=length) for pair, length in zip(pairs, lengths, strict=True))
