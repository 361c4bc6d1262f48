"""The occupancy grid of a compiled room."""

import numpy as np

from asddpg.planning.occupancy_grid import FREE, OCCUPIED, OccupancyGrid
from tasks.room_geometry.obstacles import Obstacles
from tasks.room_geometry.outlines import Outline

RESOLUTION = 0.05  # m, costmap_2d's default


def draw_room_map(obstacles: Obstacles, resolution: float = RESOLUTION) -> OccupancyGrid:
    """A room's map: a cell is occupied whose centre lies in an obstacle's outline on the floor, or within half a cell.

    It covers the fixed obstacles and a cell beyond; what lies outside of the walls is free there, and out of reach.

    Args:
        obstacles: of the room; those left out of it are not on the map.
        resolution: side of a cell, metres.
    """
    low, high = (np.array(corner) for corner in (obstacles.low, obstacles.high))
    # Centres lie on multiples of the side, as the faces of rooms often do, and not corners: rounding would decide then.
    first = np.floor(low / resolution) - 1.5
    grid = OccupancyGrid.filled(tuple(first * resolution), tuple(high + resolution), resolution, FREE)
    for outline in obstacles.outlines:
        _draw(grid, outline)
    return grid


def _draw(grid: OccupancyGrid, outline: Outline) -> None:
    """Only the cells around the outline are looked at: the cost grows with the room, not with room times obstacles."""
    corners = np.array(outline)
    begin = np.clip(grid.to_cells(corners.min(axis=0)) - 1, 0, grid.shape)
    end = np.clip(grid.to_cells(corners.max(axis=0)) + 2, 0, grid.shape)
    rows, columns = (np.arange(*bounds) for bounds in zip(begin, end, strict=True))
    centres = grid.to_points(np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1))
    if centres.size:
        distances = Obstacles((outline,), (0.0, 0.0), (0.0, 0.0)).clearance(centres)
        part = grid.cells[begin[0] : end[0], begin[1] : end[1]]
        part[distances < grid.resolution / 2] = OCCUPIED
