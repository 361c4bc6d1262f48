"""Lengths of shortest free paths through a room, for SPL (success weighted by path length)."""

from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from tasks.obstacles import Obstacles
from tasks.physics import FloatArray

IntArray = npt.NDArray[np.intp]

CELL = 0.05  # m
ROBOT_RADIUS = 0.19  # m: half the robot's width over its wheels, what driving straight through a gap needs
# Undirected and turned by 90 degrees these give 32 directions: a grid path is at most 1.3 % longer than the true one.
_STEPS = [(1, 0), (1, 1), (2, 1), (1, 2), (3, 1), (1, 3), (3, 2), (2, 3)]


class ShortestPaths:
    """A grid over a room's free space and the shortest paths along it."""

    def __init__(self, obstacles: Obstacles, half_size: float) -> None:
        """Lay the grid over the square of half side `half_size` (m) around the origin."""
        axis = np.linspace(-half_size, half_size, 2 * round(half_size / CELL) + 1)
        self._side = len(axis)
        self._points: FloatArray = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1).reshape(-1, 2)
        self._obstacles = obstacles

    def lengths(self, start: tuple[float, float], goals: FloatArray, goal_radius: float) -> FloatArray:
        """Length of the shortest free path from `start` to within `goal_radius` of each goal.

        Args:
            start: metres, world frame.
            goals: (n, 2), metres, world frame.
            goal_radius: metres.

        Returns:
            float64 (n,), metres; inf where no path leads.
        """
        nearest = int(np.argmin(np.sum((self._points - start) ** 2, axis=1)))
        from_start = dijkstra(self._graph, directed=False, indices=nearest)
        within = np.sum((self._points[None] - goals[:, None]) ** 2, axis=-1) <= goal_radius**2  # [n, cells]
        return np.asarray(np.where(within, from_start, np.inf).min(axis=1))

    @cached_property
    def _graph(self) -> csr_array:
        free = self._obstacles.clearance(self._points) >= ROBOT_RADIUS
        index = np.arange(self._side**2).reshape(self._side, self._side)
        ends, lengths = [], []
        for dx, dy in [*_STEPS, *((-dy, dx) for dx, dy in _STEPS)]:
            here, there = _pairs(index, dx, dy)
            middles = (self._points[here] + self._points[there]) / 2
            passable = free[here] & free[there] & (self._obstacles.clearance(middles) >= ROBOT_RADIUS)
            ends.append(np.stack([here[passable], there[passable]]))
            lengths.append(np.full(np.count_nonzero(passable), CELL * np.hypot(dx, dy)))
        return coo_array(
            (np.concatenate(lengths), tuple(np.concatenate(ends, axis=1))), shape=(index.size,) * 2
        ).tocsr()


def _pairs(index: IntArray, dx: int, dy: int) -> tuple[IntArray, IntArray]:
    """All pairs of cells of a grid that lie (dx, dy) cells apart, each flattened; dy ≥ 0."""
    rows, columns = index.shape
    here = index[max(0, -dx) : rows - max(0, dx), : columns - dy]
    there = index[max(0, dx) : rows - max(0, -dx), dy:]
    return here.ravel(), there.ravel()
