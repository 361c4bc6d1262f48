"""Start-goal pairs drawn for an evaluation, with the shortest paths that SPL needs."""

import numpy as np

from tasks.goals import HALF_ROOM, draw_goal
from tasks.held_out import Pair, held_out_goals
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
    obstacles = Obstacles.from_model(Physics.from_xml_path(str(scene_path(task_name))).model.ptr)
    goals = np.round([draw_goal(rng, obstacles, held_out) for _ in range(count)], 3)
    lengths = ShortestPaths(obstacles, HALF_ROOM).lengths((0.0, 0.0), goals, goal_radius)
    start = Pose(0.0, 0.0, 0.0)
    return tuple(
        Pair(start, (float(x), float(y)), round(float(length), 3))
        for (x, y), length in zip(goals, lengths, strict=True)
    )
