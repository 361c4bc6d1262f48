"""Draws rooms until the robot gets about in one."""

from collections.abc import Callable, Sequence
from math import ceil

import numpy as np
from scipy import ndimage

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.rooms.room import Obstacle, Room, Shape

TURNING_RADIUS = 0.2922  # m; Footprint.radius of the compiled Pioneer, 0.2722 m, and the 0.02 m MARGIN of FreeSpaceRule
LEAST_SHARE = 0.63  # of the largest piece in the free floor: 0.6, and what cells of 0.1 m are off
MOST_OBSTACLES = 250
_MOST_DRAWS = 200
_CELL = 0.1  # m


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
    """Share of the largest piece in the free floor of the smallest rectangle around upright boxes and cylinders.

    Free is where the robot can turn and half a cell is left: cells of 0.1 m join no piece through too narrow a gap.
    """
    points = _sample(obstacles)
    columns = ((points - points.min(axis=1, keepdims=True)) / _CELL).astype(np.intp)
    empty = np.ones(columns.max(axis=1) + 1, dtype=bool)
    empty[*columns] = False
    pieces, _ = ndimage.label(ndimage.distance_transform_edt(empty) >= TURNING_RADIUS / _CELL + 0.5)
    areas = np.bincount(pieces.ravel())[1:]
    return float(areas.max() / areas.sum()) if len(areas) else 0.0


def _sample(obstacles: Sequence[Obstacle]) -> FloatArray:
    """Points of the obstacles on the floor, at most a cell apart: (2, n), metres."""
    rows = [_describe(obstacle) for obstacle in obstacles]
    counts = [across * along for *_, across, along in rows]
    x, y, half_x, half_y, cosine, sine, is_round, across, along = np.repeat(np.array(rows).T, counts, axis=1)
    number = np.arange(len(x)) - np.repeat(np.cumsum(counts) - counts, counts)
    row = number // along
    u, v = 2.0 * row / (across - 1.0) - 1.0, 2.0 * (number - row * along) / (along - 1.0) - 1.0
    is_inside = (is_round == 0.0) | (u * u + v * v <= 1.0)
    u, v = u * half_x, v * half_y
    return np.stack([x + cosine * u - sine * v, y + sine * u + cosine * v])[:, is_inside]


def _describe(obstacle: Obstacle) -> tuple[float, float, float, float, float, float, bool, int, int]:
    """Centre, half sides, cosine and sine of its yaw, whether it is round, and numbers of points along its sides."""
    is_round = obstacle.shape is Shape.CYLINDER
    half_x, half_y = (obstacle.size[0], obstacle.size[0]) if is_round else obstacle.size[:2]
    w, *_, z = obstacle.quaternion
    across, along = (ceil(2.0 * half / _CELL) + 1 for half in (half_x, half_y))
    x, y, _ = obstacle.position
    return x, y, half_x, half_y, w * w - z * z, 2.0 * w * z, is_round, across, along
