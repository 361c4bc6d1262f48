"""Start-goal pairs for an evaluation, drawn or stored, with the shortest paths that SPL needs."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np

from tasks.constants import GOAL_RADIUS
from tasks.physics import FloatArray, Pose
from tasks.registry import make_rule
from tasks.room_geometry.grid import Grid
from tasks.room_geometry.held_out import Pair, SetName, held_out_goals, held_out_pairs
from tasks.room_geometry.obstacles import Obstacles
from tasks.scene.loading import load_model, scene_path

CELL = 0.05  # m
ROBOT_RADIUS = 0.19  # m: half the robot's width, to the centimetre: the space for driving straight through a gap


def fresh_pairs(task_name: str, rng: np.random.Generator, count: int, goal_radius: float) -> tuple[Pair, ...]:
    """Draw pairs of a task as training does, away from the goals of the stored sets."""
    return draw_pairs(task_name, rng, count, goal_radius, held_out_goals(task_name))


def draw_pairs(
    task_name: str, rng: np.random.Generator, count: int, goal_radius: float, held_out: FloatArray
) -> tuple[Pair, ...]:
    """Draw pairs whose goals keep HELD_OUT_MARGIN from the held-out goals, (n, 2) metres."""
    model = load_model(scene_path(task_name))
    rule = make_rule(task_name, model)
    drawn = [rule.draw(rng, held_out) for _ in range(count)]
    # Millimetres, and thousandths of a radian, are enough to write down.
    pairs = [
        Pair(Pose(*(round(value, 3) for value in start)), (round(x, 3), round(y, 3)), np.inf) for start, (x, y) in drawn
    ]
    return find_paths(pairs, model, goal_radius)


@cache
def stored_pairs(task_name: str, set_name: SetName, goal_radius: float) -> tuple[Pair, ...]:
    """The stored pairs of a task; for a goal radius other than GOAL_RADIUS with their shortest paths computed anew."""
    pairs = held_out_pairs(task_name, set_name)
    return pairs if goal_radius == GOAL_RADIUS else find_paths(pairs, load_model(scene_path(task_name)), goal_radius)


def find_paths(pairs: Sequence[Pair], model: mujoco.MjModel, goal_radius: float) -> tuple[Pair, ...]:
    """The pairs with the lengths of the shortest free paths to within `goal_radius` (m) of their goals.

    The robot passes every gap of its width; inf where no path leads.
    """
    grid = Grid(Obstacles.from_model(model), ROBOT_RADIUS, CELL)
    result = list(pairs)
    for start in {pair.start[:2] for pair in pairs}:
        from_start = grid.distances(grid.nearest(start))
        for index, pair in enumerate(pairs):
            if pair.start[:2] == start:
                is_goal = np.sum((grid.points - pair.goal) ** 2, axis=1) <= goal_radius**2
                length = float(from_start[is_goal].min(initial=np.inf))
                result[index] = replace(pair, shortest_path=round(length, 3))
    return tuple(result)
