"""A grid over a room's free space, and the lengths of the shortest paths along it."""

from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from tasks.physics import FloatArray
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.outlines import Outline

IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

# Undirected and turned by 90 degrees these give 32 directions.
_STEPS = [(1, 0), (1, 1), (2, 1), (1, 2), (3, 1), (1, 3), (3, 2), (2, 3)]
DIRECTIONS = [*_STEPS, *((-dy, dx) for dx, dy in _STEPS)]
LONGEST_DETOUR = 1.0132  # of a grid path over the straight one: 1 / cos(half of the 18.4 degrees between directions)


class Grid:
    """Cells whose centres keep a distance from all obstacles, and the free straight steps between them."""

    def __init__(self, obstacles: Obstacles, radius: float, cell: float) -> None:
        """Lay the grid over the room and one cell beyond it.

        Args:
            obstacles: of the room.
            radius: metres that a centre, and a path halfway between two, keeps from every obstacle.
            cell: metres from centre to centre; the centres lie at its multiples.
        """
        self.cell = cell
        self._first = np.floor(np.array(obstacles.low) / cell).astype(int) - 1
        self.shape: tuple[int, int] = tuple(np.ceil(np.array(obstacles.high) / cell).astype(int) + 2 - self._first)
        # Cells and the points halfway between two of them lie on one lattice of half the width.
        self._clearance = _clearances(obstacles, 2 * self._first, self.shape, cell / 2, radius + cell)
        self._free = self._clearance >= radius
        self.free: BoolArray = self._free[::2, ::2].ravel()
        self.clearance: FloatArray = self._clearance[::2, ::2].ravel()

    @cached_property
    def points(self) -> FloatArray:
        """Centres of all cells, free or not, row by row: float64 (cells, 2), metres, world frame."""
        rows, columns = (np.arange(count) + first for first, count in zip(self._first, self.shape, strict=True))
        return np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1).reshape(-1, 2) * self.cell

    def nearest(self, point: tuple[float, float]) -> int:
        """The cell, free or not, whose centre lies nearest to a point, metres."""
        return int(np.argmin(np.sum((self.points - point) ** 2, axis=1)))

    def distances(self, cells: npt.ArrayLike, limit: float = np.inf) -> FloatArray:
        """Lengths of the shortest paths from some cells to every cell.

        Args:
            cells: indices, (...).
            limit: metres; longer paths are not searched.

        Returns:
            float64 (..., cells), metres; inf where no path leads.
        """
        return np.asarray(dijkstra(self.graph, indices=cells, limit=limit))

    @cached_property
    def graph(self) -> csr_array:
        """Lengths in metres of the steps from cell to cell, each in both directions."""
        index = np.arange(self.free.size).reshape(self.shape)
        ends, lengths = [], []
        for dx, dy in DIRECTIONS:
            here, there = _pairs(index, dx, dy)
            rows, columns = np.divmod(here, self.shape[1])
            passable = self.free[here] & self.free[there] & self._free[2 * rows + dx, 2 * columns + dy]
            ends.append(np.stack([here[passable], there[passable]]))
            lengths.append(np.full(np.count_nonzero(passable), self.cell * np.hypot(dx, dy)))
        forth, length = np.concatenate(ends, axis=1), np.concatenate(lengths)
        both = np.concatenate([forth, forth[::-1]], axis=1)
        return coo_array((np.concatenate([length, length]), tuple(both)), shape=(index.size,) * 2).tocsr()


def _clearances(
    obstacles: Obstacles, first: IntArray, cells: tuple[int, int], spacing: float, cap: float
) -> FloatArray:
    """Distances to the nearest obstacle, at most `cap`, on the lattice of the cells and of the points halfway.

    Each obstacle is evaluated only in its neighbourhood: the cost grows with the room, not with room times obstacles.
    """
    lattice = np.full((2 * cells[0] - 1, 2 * cells[1] - 1), cap)
    for shape in obstacles.outlines:
        low, high = np.min(shape, axis=0) - cap, np.max(shape, axis=0) + cap
        begin = np.clip(np.floor(low / spacing).astype(int) - first, 0, lattice.shape)
        end = np.clip(np.ceil(high / spacing).astype(int) + 1 - first, 0, lattice.shape)
        window = lattice[begin[0] : end[0], begin[1] : end[1]]
        axes = [(np.arange(b, e) + f) * spacing for b, e, f in zip(begin, end, first, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        np.minimum(window, _single_obstacle(shape).clearance(points), out=window)
    return lattice


def _single_obstacle(shape: Outline) -> Obstacles:
    return Obstacles((shape,), (0.0, 0.0), (0.0, 0.0))


def _pairs(index: IntArray, dx: int, dy: int) -> tuple[IntArray, IntArray]:
    """All pairs of cells of a grid that lie (dx, dy) cells apart, each flattened; dy ≥ 0."""
    rows, columns = index.shape
    here = index[max(0, -dx) : rows - max(0, dx), : columns - dy]
    there = index[max(0, dx) : rows - max(0, -dx), dy:]
    return here.ravel(), there.ravel()
