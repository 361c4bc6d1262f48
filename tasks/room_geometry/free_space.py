"""Places of a room where the robot can stand and turn, and pairs of them a given path apart, drawn without a search.

The searches are done beforehand, from landmarks that lie within a tile of every place. With d(L, S) and all d(L, G)
known, d(S, G) is known to within d(L, S). Of the goals sorted by d(L, G), those whose path from S certainly keeps the
bounds are one range. A draw is then two random numbers for two cells.
"""

from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components

from tasks.errors import TaskError
from tasks.physics import FloatArray
from tasks.room_geometry.grid import LONGEST_DETOUR, BoolArray, Grid, IntArray
from tasks.room_geometry.obstacles import Obstacles

CELL = 0.1  # m
TILE = 1.0  # m; least side of the tiles that have a landmark each
_TILES = 300  # about the largest number of tiles, which grow in large rooms: searches and memory go with it
_AT_ONCE = 64  # searches in one call, whose result takes eight bytes for each cell of the grid

Point = tuple[float, float]


class FreeSpace:
    """The one piece of a room's free space that episodes take place in.

    It is the piece around the robot's position in the scene's file; if that lies in an obstacle, the largest piece that
    walls enclose; if none is enclosed, the largest.
    """

    def __init__(self, obstacles: Obstacles, radius: float, home: Point) -> None:
        """Find the places and the lengths of the paths between them.

        Args:
            obstacles: of the room.
            radius: metres to keep from every obstacle.
            home: the robot's position in the scene's file, metres, world frame.

        Raises:
            TaskError: no place is free.
        """
        grid = Grid(obstacles, radius, CELL)
        if not grid.free.any():
            raise TaskError(
                f"the room leaves no free place: the robot needs a circle of {radius:.2f} m radius clear of obstacles"
            )
        cells = _find_piece(grid, home)
        self.centres = grid.points[cells]  # [cells, 2]
        # Largest distance of a place from its cell's centre along x and along y.
        self._play = np.minimum(CELL / 2, (grid.clearance[cells] - radius) / np.sqrt(2))
        landmarks = _find_landmarks(grid, cells)
        parts = np.split(landmarks, range(_AT_ONCE, len(landmarks), _AT_ONCE))
        # [landmarks, cells]
        distances = np.concatenate([grid.distances(part)[:, cells].astype(np.float32) for part in parts])
        self._landmark: IntArray = np.argmin(distances, axis=0)
        self._offset: FloatArray = distances[self._landmark, np.arange(len(cells))].astype(np.float64)
        # Stable: otherwise the order of equal distances, and with it every draw, depends on the processor.
        self._by_distance = np.argsort(distances, axis=1, kind="stable").astype(np.int32)
        self._distances = np.take_along_axis(distances, self._by_distance, axis=1)

    @property
    def longest_path(self) -> float:
        """An upper bound on the shortest path between two cells, metres; too long by a tile at most."""
        return float(self._distances.max() + self._offset.max())

    def goal_ranges(self, min_path: float, max_path: float) -> tuple[IntArray, IntArray]:
        """For every cell as a start, the first and last (exclusive) rank of its goals among the cells by distance.

        Args:
            min_path: metres, least length of the shortest path from start to goal.
            max_path: metres, greatest length.

        Returns:
            Two integer arrays (cells,); for a start without goals last ≤ first.
        """
        # Both places may lie off their cells' centres.
        unsure = self._offset + np.sqrt(2) * (self._play + CELL / 2)
        nearest = (min_path + unsure) * LONGEST_DETOUR if min_path > 0.0 else np.zeros_like(unsure)
        first, last = np.zeros_like(self._landmark), np.zeros_like(self._landmark)
        for landmark, distances in enumerate(self._distances):
            mine = np.flatnonzero(self._landmark == landmark)
            first[mine] = np.searchsorted(distances, nearest[mine], side="left")
            last[mine] = np.searchsorted(distances, max_path - unsure[mine], side="right")
        return first, last

    def goal_cell(self, start_cell: int, rank: int) -> int:
        """The cell of a rank in the order by distance from the start's landmark."""
        return int(self._by_distance[self._landmark[start_cell], rank])

    def draw_place(self, cell: int, rng: np.random.Generator) -> Point:
        """Draw a place uniformly from a cell, no nearer to any obstacle than the radius; metres, world frame."""
        x, y = self.centres[cell].tolist()
        play = float(self._play[cell])
        return x + play * rng.uniform(-1.0, 1.0), y + play * rng.uniform(-1.0, 1.0)


@lru_cache(maxsize=8)
def free_space(obstacles: Obstacles, radius: float, home: Point) -> FreeSpace:
    """The free space of a room, computed once for all environments of a process."""
    return FreeSpace(obstacles, radius, home)


def _find_piece(grid: Grid, home: Point) -> IntArray:
    """Indices of the grid's cells that belong to the room."""
    _, pieces = connected_components(grid.graph, directed=False)
    at_home = grid.nearest(home)
    if grid.free[at_home] and np.hypot(*(grid.points[at_home] - home)) < CELL:
        return np.flatnonzero(pieces == pieces[at_home])
    areas = np.bincount(pieces[grid.free], minlength=pieces.max() + 1)
    enclosed = np.where(np.isin(np.arange(len(areas)), pieces[_border(grid) & grid.free]), 0, areas)
    return np.flatnonzero(pieces == np.argmax(enclosed if enclosed.any() else areas))


def _border(grid: Grid) -> BoolArray:
    inner = np.zeros(grid.shape, dtype=bool)
    inner[1:-1, 1:-1] = True
    return ~inner.ravel()


def _find_landmarks(grid: Grid, cells: IntArray) -> IntArray:
    """The middle cell of each tile, or of each part of a tile that walls divide."""
    tile = max(TILE, CELL * np.sqrt(len(cells) / _TILES))
    tiles = np.floor(grid.points / tile).astype(int)
    graph = grid.graph.tocoo()
    within = np.all(tiles[graph.row] == tiles[graph.col], axis=1)
    graph.data = np.where(within, graph.data, 0.0)
    graph.eliminate_zeros()
    _, parts = connected_components(graph, directed=False)
    return np.array([_middle(grid.points, cells[group]) for group in _groups(parts[cells])])


def _groups(labels: npt.NDArray[np.integer]) -> list[IntArray]:
    """Positions of each label."""
    order = np.argsort(labels, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(labels[order])) + 1)


def _middle(points: FloatArray, cells: IntArray) -> int:
    from_middle = points[cells] - points[cells].mean(axis=0)
    return int(cells[np.argmin(np.sum(from_middle**2, axis=1))])
