"""Goals of the paper's three rooms, drawn by the rule of the released code."""

import numpy as np

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.room_geometry.obstacles import Obstacles

HALF_ROOM = 4.0  # m; the rooms are 8 x 8 m inside
WALL_MARGIN = 0.3  # m between goal and outer wall; released code
CENTRE_HALF_SIZE = 2.0  # m; no goal in |x| < 2 and |y| < 2 together; released code
OBSTACLE_MARGIN = 0.25  # m between goal and obstacles; released code
HELD_OUT_MARGIN = 0.1  # m between a drawn goal and the goals of the stored evaluation sets

_MAX_DRAWS = 10_000


def is_allowed(goal: FloatArray, obstacles: Obstacles) -> bool:
    """Whether the released code's rule allows a goal, (2,) metres."""
    in_room = bool(np.all(np.abs(goal) <= HALF_ROOM - WALL_MARGIN))
    in_centre = bool(np.all(np.abs(goal) < CENTRE_HALF_SIZE))
    return in_room and not in_centre and bool(obstacles.clearance(goal) >= OBSTACLE_MARGIN)


def draw_goal(rng: np.random.Generator, obstacles: Obstacles, held_out: FloatArray) -> FloatArray:
    """Draw a goal uniformly from those that the rule allows, away from the held-out goals.

    Args:
        rng: source of randomness.
        obstacles: of the room, walls included.
        held_out: (n, 2) metres, the goals that training keeps away from.

    Returns:
        float64 (2,), metres, world frame.
    """
    reach = HALF_ROOM - WALL_MARGIN
    for _ in range(_MAX_DRAWS):
        goal = rng.uniform(-reach, reach, size=2)
        near_held_out = len(held_out) and np.min(np.sum((held_out - goal) ** 2, axis=1)) <= HELD_OUT_MARGIN**2
        if not near_held_out and is_allowed(goal, obstacles):
            return goal
    raise TaskError(f"{_MAX_DRAWS} draws found no goal: the room leaves no free place for one by the paper's rule")
