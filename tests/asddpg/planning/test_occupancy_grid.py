"""Occupancy grids: where a point lies, and what a cell holds."""

import numpy as np

from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid


def test_rows_go_along_y_and_columns_along_x() -> None:
    grid = OccupancyGrid.filled((-1.0, -2.0), (1.0, 2.0), 0.5)
    assert grid.shape == (8, 4)
    assert grid.to_cells((-0.9, -2.0)).tolist() == [0, 0]
    assert grid.to_cells([[0.6, -1.9], [-0.9, 1.99]]).tolist() == [[0, 3], [7, 0]]


def test_a_cells_centre_lies_in_the_cell() -> None:
    grid = OccupancyGrid.filled((-1.03, 0.2), (0.8, 1.1), 0.05)
    cells = np.stack(np.meshgrid(*(np.arange(count) for count in grid.shape), indexing="ij"), axis=-1)
    assert (grid.to_cells(grid.to_points(cells)) == cells).all()
    assert np.allclose(grid.to_points((0, 0)), (-1.005, 0.225))


def test_cells_outside_are_not_contained() -> None:
    grid = OccupancyGrid.filled((0.0, 0.0), (1.0, 0.5), 0.1)
    points = [(0.05, 0.05), (0.95, 0.45), (-0.01, 0.1), (0.1, 0.51), (1.01, 0.1)]
    assert grid.contains(grid.to_cells(points)).tolist() == [True, True, False, False, False]


def test_occupied_from_map_servers_threshold_on() -> None:
    grid = OccupancyGrid(np.array([[UNKNOWN, FREE, 64, 65, OCCUPIED]], dtype=np.int8), 0.1, (0.0, 0.0))
    assert grid.occupied.tolist() == [[False, False, False, True, True]]
    assert grid.unknown.tolist() == [[True, False, False, False, False]]
