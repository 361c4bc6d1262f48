"""Costmaps: a map whose obstacles are inflated by the robot's size (costmap_2d of ROS)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from asddpg.planning.occupancy_grid import FloatArray, OccupancyGrid

LETHAL, INSCRIBED = 254, 253  # an obstacle is there; the robot touches one, whatever its heading


@dataclass(frozen=True)
class Inflation:
    """How the cost falls with the distance to the nearest obstacle.

    Attributes:
        inscribed_radius: of the largest circle about the base's axis inside the robot, metres.
        radius: metres; beyond it nothing costs.
        scaling: 1/m; beyond the inscribed radius the cost falls by exp(−scaling · metres).
    """

    inscribed_radius: float
    radius: float = 0.55
    scaling: float = 10.0

    def cost(self, distance: npt.ArrayLike) -> npt.NDArray[np.uint8]:
        """Cost at distances (m) to the nearest occupied cell's centre, 0 within it: uint8, the same shape."""
        metres = np.asarray(distance, dtype=np.float64)
        falling = (INSCRIBED - 1) * np.exp(-self.scaling * (metres - self.inscribed_radius))
        cost = np.where(metres <= self.inscribed_radius, INSCRIBED, np.minimum(falling, INSCRIBED - 1))
        cost = np.where(metres > self.radius, 0, cost)
        return np.where(metres <= 0.0, LETHAL, cost).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class Costmap:
    """A map and the cost of the robot's axis being in each cell.

    Attributes:
        grid: the map.
        costs: uint8 (rows, columns); 0 free, INSCRIBED and more impassable.
        inflation: by which it was made.
    """

    grid: OccupancyGrid
    costs: npt.NDArray[np.uint8]
    inflation: Inflation

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, inflation: Inflation) -> "Costmap":
        """Inflate a map's obstacles; unknown cells count as free, as move_base's planner takes them."""
        return cls(grid, inflation.cost(distance_to_obstacles(grid)), inflation)

    @property
    def passable(self) -> npt.NDArray[np.bool_]:
        """Cells where the robot may be, (rows, columns)."""
        return self.costs < INSCRIBED

    def least_cost_within(self, distance: float) -> int:
        """A cost that no cell falls below which has an obstacle's cell within a distance, metres."""
        # Both ends may lie off their cells' centres.
        return int(self.inflation.cost(distance + self.grid.resolution * np.sqrt(2.0)))

    def is_passable(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether the robot may be at points (..., 2), metres, map frame: (...)."""
        return self.cost_at(points) < INSCRIBED

    def cost_at(self, points: npt.ArrayLike) -> npt.NDArray[np.uint8]:
        """Costs at points (..., 2), metres, map frame; LETHAL outside of the map."""
        cells = self.grid.to_cells(points)
        rows, columns = self.grid.shape
        row, column = cells[..., 0], cells[..., 1]
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        costs = self.costs.ravel().take(row * columns + column, mode="clip")
        return np.where(inside, costs, np.uint8(LETHAL))


def distance_to_obstacles(grid: OccupancyGrid) -> FloatArray:
    """Metres from each cell's centre to that of the nearest occupied cell, (rows, columns); inf without any."""
    occupied = grid.occupied
    if not occupied.any():
        return np.full(grid.shape, np.inf)
    distances: FloatArray = distance_transform_edt(~occupied) * grid.resolution
    return distances
