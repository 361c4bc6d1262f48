"""Lengths of shortest free paths through a room, for SPL (success weighted by path length)."""

import numpy as np

from tasks.physics import FloatArray
from tasks.room_geometry.grid import Grid
from tasks.room_geometry.obstacles import Obstacles

CELL = 0.05  # m
ROBOT_RADIUS = 0.19  # m: half the robot's width, to the centimetre: the space for driving straight through a gap


class ShortestPaths:
    """The shortest paths on which the robot fits through a room."""

    def __init__(self, obstacles: Obstacles) -> None:
        self._grid = Grid(obstacles, ROBOT_RADIUS, CELL)

    def lengths(self, start: tuple[float, float], goals: FloatArray, goal_radius: float) -> FloatArray:
        """Length of the shortest free path from `start` to within `goal_radius` of each goal.

        Args:
            start: metres, world frame.
            goals: (n, 2), metres, world frame.
            goal_radius: metres.

        Returns:
            float64 (n,), metres; inf where no path leads.
        """
        from_start = self._grid.distances(self._grid.nearest(start))
        within = np.sum((self._grid.points[None] - goals[:, None]) ** 2, axis=-1) <= goal_radius**2  # [n, cells]
        return np.asarray(np.where(within, from_start, np.inf).min(axis=1))
