"""Start-goal pairs for an evaluation, drawn or stored, with the shortest paths that SPL needs."""

import dataclasses
from collections.abc import Sequence
from functools import cache

import mujoco
import numpy as np

from tasks.constants import GOAL_RADIUS
from tasks.physics import FloatArray, Pose
from tasks.registry import make_rule
from tasks.room_geometry.held_out import Pair, SetName, held_out_goals, held_out_pairs
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.shortest_paths import ShortestPaths
from tasks.scene.loading import load_model, scene_path


def fresh_pairs(task_name: str, rng: np.random.Generator, count: int, goal_radius: float) -> tuple[Pair, ...]:
    """Draw pairs of a task as training does, away from the goals of the stored sets."""
    return draw_pairs(task_name, rng, count, goal_radius, held_out_goals(task_name))


def draw_pairs(
    task_name: str, rng: np.random.Generator, count: int, goal_radius: float, held_out: FloatArray
) -> tuple[Pair, ...]:
    """Draw pairs whose goals keep HELD_OUT_MARGIN from the held-out goals, (n, 2) metres."""
    model = _model(task_name)
    rule = make_rule(task_name, model)
    drawn = [rule.draw(rng, held_out) for _ in range(count)]
    # Millimetres, and thousandths of a radian, are enough to write down.
    pairs = [
        Pair(Pose(*(round(value, 3) for value in start)), (round(x, 3), round(y, 3)), np.inf) for start, (x, y) in drawn
    ]
    return _with_paths(pairs, model, goal_radius)


@cache
def stored_pairs(task_name: str, set_name: SetName, goal_radius: float) -> tuple[Pair, ...]:
    """The stored pairs of a task; for a goal radius other than GOAL_RADIUS with their shortest paths computed anew."""
    pairs = held_out_pairs(task_name, set_name)
    return pairs if goal_radius == GOAL_RADIUS else _with_paths(pairs, _model(task_name), goal_radius)


def _model(task_name: str) -> mujoco.MjModel:
    return load_model(scene_path(task_name))


def _with_paths(pairs: Sequence[Pair], model: mujoco.MjModel, goal_radius: float) -> tuple[Pair, ...]:
    """The pairs with the lengths of their shortest paths."""
    paths = ShortestPaths(Obstacles.from_model(model))
    goals_from: dict[tuple[float, float], list[int]] = {}
    for index, pair in enumerate(pairs):
        goals_from.setdefault((pair.start.x, pair.start.y), []).append(index)
    result = list(pairs)
    for start, indices in goals_from.items():
        goals = np.array([pairs[index].goal for index in indices])
        lengths = paths.lengths(start, goals, goal_radius).round(3).tolist()
        for index, length in zip(indices, lengths, strict=True):
            result[index] = dataclasses.replace(pairs[index], shortest_path=length)
    return tuple(result)
