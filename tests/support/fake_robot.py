"""A robot for tests of planners: a rectangle that is where the test says, in a map that the test draws."""

from collections.abc import Sequence

import numpy as np

from asddpg.episodes.protocols import Observation
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, BoolArray, FloatArray, OccupancyGrid
from asddpg.planning.robot import Reading, RobotShape

# 0.4 m long and 0.3 m wide, its axis in the middle.
FOOTPRINT = np.array([(0.2, -0.15), (0.2, 0.15), (-0.2, 0.15), (-0.2, -0.15)])
MAX_RANGE = 5.0


def make_shape(
    beams: Sequence[float] = (0.0,), low: tuple[float, float] = (0.0, -1.0), high: tuple[float, float] = (0.5, 1.0)
) -> RobotShape:
    return RobotShape(FOOTPRINT, 0.15, (0.0, 0.0), np.array(beams), MAX_RANGE, 0.2, low, high)


def make_reading(
    pose: tuple[float, float, float],
    goal: tuple[float, float] = (0.0, 0.0),
    ranges: Sequence[float] = (np.inf,),
    velocity: tuple[float, float] = (0.0, 0.0),
) -> Reading:
    return Reading(pose, velocity, goal, np.array(ranges))


class FakeRobot:
    """Its reading is set by the test, whatever the observation."""

    def __init__(self, grid: OccupancyGrid | None, reading: Reading, shape: RobotShape | None = None) -> None:
        self.map, self.reading = grid, reading
        self.shape: RobotShape = shape or make_shape()

    def read(self, observation: Observation) -> Reading:
        return self.reading


def free_map(width: float = 4.0, height: float = 4.0) -> OccupancyGrid:
    """Cells of 0.1 m, the lowest corner at the origin."""
    return OccupancyGrid.filled((0.0, 0.0), (width, height), 0.1, FREE)


def map_with_gap() -> OccupancyGrid:
    """4 × 4 m with a wall across it, x from 2.0 to 2.1 m, but for y from 3.0 to 3.8 m."""
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    grid.cells[30:38, 20] = FREE
    return grid


def drawn(*lines: str) -> BoolArray:
    """`#` is True; the first line is row 0."""
    return np.array([[sign == "#" for sign in line] for line in lines])


def straight(begin: tuple[float, float], end: tuple[float, float], count: int) -> FloatArray:
    return np.linspace(begin, end, count)
