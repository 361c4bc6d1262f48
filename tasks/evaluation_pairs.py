"""Start-goal pairs for an evaluation, drawn or stored, with the shortest paths that SPL needs."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np

from tasks.constants import GOAL_RADIUS
from tasks.physics import FloatArray, Pose
from tasks.registry import OWN_ROOM, find_task, make_rule, task_model
from tasks.room_geometry.grid import Grid
from tasks.room_geometry.held_out import Pair, SetName, held_out_goals, held_out_pairs
from tasks.room_geometry.obstacles import Obstacles
from tasks.rooms.pairs import draw_sets
from tasks.rooms.reading import find_room

CELL, ROOM_CELL = 0.05, 0.1  # m; of a room that is a file or is generated: its paths are not stored
ROBOT_RADIUS = 0.19  # m: half the robot's width, to the centimetre: the space for driving straight through a gap


def fresh_pairs(task_name: str, rng: np.random.Generator, count: int, goal_radius: float) -> tuple[Pair, ...]:
    """Draw pairs of a task as training does, away from the goals of the stored sets."""
    held_out = np.zeros((0, 2)) if find_task(task_name) is OWN_ROOM else held_out_goals(task_name)
    return draw_pairs(task_name, rng, count, goal_radius, held_out)


def draw_pairs(
    task_name: str, rng: np.random.Generator, count: int, goal_radius: float, held_out: FloatArray
) -> tuple[Pair, ...]:
    """Draw pairs whose goals keep HELD_OUT_MARGIN from the held-out goals, (n, 2) metres."""
    model = task_model(task_name)
    rule = make_rule(task_name, model)
    drawn = [rule.draw(rng, held_out) for _ in range(count)]
    # Millimetres, and thousandths of a radian, are enough to write down.
    pairs = [
        Pair(Pose(*(round(value, 3) for value in start)), (round(x, 3), round(y, 3)), np.inf) for start, (x, y) in drawn
    ]
    return find_paths(pairs, model, goal_radius)


@cache
def stored_pairs(task_name: str, set_name: SetName, goal_radius: float, count: int | None = None) -> tuple[Pair, ...]:
    """The stored pairs of a task, or those of a room: the first `count`, or all.

    Shortest paths are computed anew for a goal radius other than GOAL_RADIUS, and in rooms that are files or generated.
    """
    if find_task(task_name) is OWN_ROOM:
        model = task_model(task_name)
        return find_paths(_room_sets(task_name, model)[set_name][:count], model, goal_radius, ROOM_CELL)
    pairs = held_out_pairs(task_name, set_name)[:count]
    return pairs if goal_radius == GOAL_RADIUS else find_paths(pairs, task_model(task_name), goal_radius)


def _room_sets(task_name: str, model: mujoco.MjModel) -> Mapping[SetName, Sequence[Pair]]:
    return draw_sets(find_room(task_name), make_rule(task_name, model))


def find_paths(
    pairs: Sequence[Pair], model: mujoco.MjModel, goal_radius: float, cell: float = CELL
) -> tuple[Pair, ...]:
    """The pairs with the lengths of the shortest free paths to within `goal_radius` (m) of their goals.

    The robot passes every gap of its width; inf where no path leads. They are found on a grid of `cell` metres.
    """
    grid = Grid(Obstacles.from_model(model), ROBOT_RADIUS, cell)
    result = list(pairs)
    for start in {pair.start[:2] for pair in pairs}:
        from_start = grid.distances(grid.nearest(start))
        for index, pair in enumerate(pairs):
            if pair.start[:2] == start:
                is_goal = np.sum((grid.points - pair.goal) ** 2, axis=1) <= goal_radius**2
                length = float(from_start[is_goal].min(initial=np.inf))
                result[index] = replace(pair, shortest_path=round(length, 3))
    return tuple(result)
