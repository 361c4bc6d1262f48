"""Occupancy grids, by the conventions of ROS (nav_msgs/OccupancyGrid, map_server)."""

from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.intp]
BoolArray = npt.NDArray[np.bool_]

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
OCCUPIED_FROM = 65  # %; map_server's occupied_thresh


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """A map.

    Attributes:
        cells: int8 (rows, columns), the probability of an obstacle in percent, or UNKNOWN. Rows go along y and columns
            along x; cell (0, 0) has the lowest x and y.
        resolution: side of a cell, metres.
        origin: x and y of the outer corner of cell (0, 0), metres, map frame.
    """

    cells: npt.NDArray[np.int8]
    resolution: float
    origin: tuple[float, float]

    @classmethod
    def filled(
        cls, low: tuple[float, float], high: tuple[float, float], resolution: float, value: int = UNKNOWN
    ) -> Self:
        """A grid over the rectangle from `low` to `high` (x, y; metres), every cell of one value."""
        columns, rows = (max(1, int(np.ceil((b - a) / resolution - 1e-9))) for a, b in zip(low, high, strict=True))
        return cls(np.full((rows, columns), value, dtype=np.int8), resolution, (float(low[0]), float(low[1])))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        rows, columns = self.cells.shape
        return rows, columns

    @property
    def occupied(self) -> BoolArray:
        """Cells that hold an obstacle, (rows, columns)."""
        return np.asarray(self.cells >= OCCUPIED_FROM)

    @property
    def unknown(self) -> BoolArray:
        """Cells of which nothing is known, (rows, columns)."""
        return np.asarray(self.cells == UNKNOWN)

    def to_cells(self, points: npt.ArrayLike) -> IntArray:
        """Row and column of the cells that points lie in, whether or not the grid has them.

        Args:
            points: x and y, metres, map frame, (..., 2).

        Returns:
            int (..., 2).
        """
        offsets = (np.asarray(points, dtype=np.float64) - self.origin) / self.resolution
        return np.floor(offsets[..., ::-1]).astype(np.intp)

    def to_points(self, cells: npt.ArrayLike) -> FloatArray:
        """Centres of cells (row, column), (..., 2): x and y, metres, map frame, (..., 2)."""
        return (np.asarray(cells)[..., ::-1] + 0.5) * self.resolution + self.origin

    def contains(self, cells: npt.ArrayLike) -> BoolArray:
        """Whether the grid has cells (row, column), (..., 2): (...)."""
        found = np.asarray(cells)
        return np.asarray(((found >= 0) & (found < self.shape)).all(axis=-1))

    def with_obstacles(self, occupied: BoolArray) -> "OccupancyGrid":
        """The same map with further occupied cells, (rows, columns)."""
        return OccupancyGrid(np.where(occupied, np.int8(OCCUPIED), self.cells), self.resolution, self.origin)
