"""A room's floor in cells, from its obstacles alone: 0.3 ms, where a compiled scene's outlines take 20."""

from collections.abc import Sequence
from functools import lru_cache
from math import ceil
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from tasks.physics import FloatArray
from tasks.rooms.room import Obstacle, Point, Shape

CELL = 0.1  # m

IntArray = npt.NDArray[np.intp]


class FloorCells(NamedTuple):
    """Cells of the smallest rectangle around some obstacles.

    Attributes:
        low: corner of the first cell, (2,), metres.
        pieces: number of each cell's piece of free floor, from 1, and 0 where the robot has no room to turn: (along x,
            along y).
    """

    low: FloatArray
    pieces: IntArray

    def largest(self) -> FloatArray:
        """Centres of the cells of the largest piece, (n, 2), metres; (0, 2) without any."""
        areas = np.bincount(self.pieces.ravel())
        areas[0] = 0
        cells = np.argwhere(self.pieces == areas.argmax()) if areas.any() else np.zeros((0, 2))
        centres: FloatArray = self.low + (cells + 0.5) * CELL
        return centres


@lru_cache(maxsize=2)  # a room's generator has divided its floor when its rule does
def divide_floor(obstacles: tuple[Obstacle, ...], radius: float, places: tuple[Point, ...]) -> FloorCells:
    """The pieces of free floor among upright boxes and cylinders; do not change them.

    Free is where a circle of that radius fits and half a cell is left: cells join no piece through too narrow a gap.

    Args:
        obstacles: one or more.
        radius: metres.
        places: further ones within the rectangle, metres.
    """
    points = _sample(obstacles)
    extent = np.concatenate([points, np.array(places).reshape(-1, 2).T], axis=1)
    low = extent.min(axis=1)
    size = ((extent.max(axis=1) - low) / CELL).astype(np.intp) + 1
    columns = ((points - low[:, None]) / CELL).astype(np.intp)
    empty = np.ones(size, dtype=bool)
    empty[*columns] = False
    pieces, _ = ndimage.label(ndimage.distance_transform_edt(empty) >= radius / CELL + 0.5)
    return FloorCells(low, pieces)


def clearance(obstacles: FloatArray, x: float, y: float) -> float:
    """Distance from a point to the nearest of some obstacles, 0 within one; metres; rows as describe() gives them."""
    centre_x, centre_y, half_x, half_y, cosine, sine, is_round = obstacles.T[:7]
    dx, dy = x - centre_x, y - centre_y
    u, v = np.abs(cosine * dx + sine * dy), np.abs(cosine * dy - sine * dx)
    from_box = np.hypot(np.maximum(u - half_x, 0.0), np.maximum(v - half_y, 0.0))
    distances = np.where(is_round, np.maximum(np.hypot(u, v) - half_x, 0.0), from_box)
    return float(distances.min(initial=np.inf))


def describe(obstacles: Sequence[Obstacle]) -> FloatArray:
    """Upright boxes and cylinders as rows, (n, 9).

    Centre and half sides, metres; cosine and sine of the yaw; whether it is round; numbers of points along its sides,
    at most a cell apart.
    """
    return np.array([_describe(obstacle) for obstacle in obstacles]).reshape(-1, 9)


def _describe(obstacle: Obstacle) -> tuple[float, float, float, float, float, float, bool, int, int]:
    is_round = obstacle.shape is Shape.CYLINDER
    half_x, half_y = (obstacle.size[0], obstacle.size[0]) if is_round else obstacle.size[:2]
    w, *_, z = obstacle.quaternion
    across, along = (ceil(2.0 * half / CELL) + 1 for half in (half_x, half_y))
    x, y, _ = obstacle.position
    return x, y, half_x, half_y, w * w - z * z, 2.0 * w * z, is_round, across, along


def _sample(obstacles: Sequence[Obstacle]) -> FloatArray:
    """Points of the obstacles on the floor, at most a cell apart: (2, n), metres."""
    rows = describe(obstacles)
    counts = (rows[:, 7] * rows[:, 8]).astype(np.intp)
    x, y, half_x, half_y, cosine, sine, is_round, across, along = np.repeat(rows.T, counts, axis=1)
    number = np.arange(len(x)) - np.repeat(np.cumsum(counts) - counts, counts)
    row = number // along
    u, v = 2.0 * row / (across - 1.0) - 1.0, 2.0 * (number - row * along) / (along - 1.0) - 1.0
    is_inside = (is_round == 0.0) | (u * u + v * v <= 1.0)
    u, v = u * half_x, v * half_y
    return np.stack([x + cosine * u - sine * v, y + sine * u + cosine * v])[:, is_inside]
