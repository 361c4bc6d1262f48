"""Draws rooms until the robot gets about in one."""

from collections.abc import Callable, Sequence

import numpy as np

from tasks.errors import TaskError
from tasks.rooms.floor_cells import divide_floor
from tasks.rooms.room import Obstacle, Room

TURNING_RADIUS = 0.2922  # m; Footprint.radius of the compiled Pioneer, 0.2722 m, and the 0.02 m MARGIN of FreeSpaceRule
LEAST_SHARE = 0.63  # of the largest piece in the free floor: 0.6, and what cells of 0.1 m are off
MOST_OBSTACLES = 250
_MOST_DRAWS = 200


def draw_connected(sketch: Callable[[np.random.Generator], Sequence[Obstacle]], rng: np.random.Generator) -> Room:
    """Draw a room of at most MOST_OBSTACLES whose free floor is, for the most part, one piece.

    Args:
        sketch: draws the obstacles, walls all around the floor among them.
        rng: source of randomness.

    Raises:
        TaskError: no draw of many gives such a room.
    """
    for _ in range(_MOST_DRAWS):
        obstacles = tuple(sketch(rng))
        if len(obstacles) <= MOST_OBSTACLES and largest_share(obstacles) >= LEAST_SHARE:
            return Room(obstacles)
    raise TaskError(f"{_MOST_DRAWS} draws gave no room in which the robot gets about")


def largest_share(obstacles: Sequence[Obstacle]) -> float:
    """Share of the largest piece in the free floor of the smallest rectangle around upright boxes and cylinders."""
    areas = np.bincount(divide_floor(tuple(obstacles), TURNING_RADIUS, ()).pieces.ravel())[1:]
    return float(areas.max() / areas.sum()) if len(areas) else 0.0
