"""Costs of inflated obstacles, against values worked out by hand."""

import numpy as np
import pytest

from asddpg.planning.costmap import INSCRIBED, LETHAL, Costmap, Inflation, distance_to_obstacles
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from tests.support.fake_robot import free_map

INFLATION = Inflation(inscribed_radius=0.15, radius=0.55, scaling=10.0)


def test_the_cost_falls_exponentially_beyond_the_inscribed_radius() -> None:
    inflation = Inflation(inscribed_radius=0.2, radius=0.55, scaling=10.0)
    # 252 e^0, 252 e^−1 = 92.7, 252 e^−2 = 34.1 and 252 e^−3.5 = 7.6, cut to whole numbers
    assert inflation.cost([0.2000001, 0.3, 0.4, 0.55]).tolist() == [251, 92, 34, 7]
    # 252 e^(−5 · 0.1) = 152.8
    assert int(Inflation(0.2, 0.55, 5.0).cost(0.3)) == 152


def test_an_obstacle_is_lethal_and_its_surroundings_touch_the_robot() -> None:
    inflation = Inflation(inscribed_radius=0.2, radius=0.55, scaling=10.0)
    assert (LETHAL, INSCRIBED) == (254, 253)
    assert inflation.cost([0.0, 1e-9, 0.1, 0.2]).tolist() == [LETHAL, INSCRIBED, INSCRIBED, INSCRIBED]


def test_beyond_the_inflation_radius_nothing_costs() -> None:
    assert INFLATION.cost([0.5500001, 3.0, np.inf]).tolist() == [0, 0, 0]


def test_distances_go_from_centre_to_centre() -> None:
    grid = free_map(1.0, 0.6)
    grid.cells[1, 2] = OCCUPIED
    distances = distance_to_obstacles(grid)
    assert distances.shape == (6, 10)
    assert distances[1, 2] == 0.0
    assert distances[4, 6] == pytest.approx(0.5)  # 3 rows and 4 columns of 0.1 m
    assert distances[1, 9] == pytest.approx(0.7)


def test_a_map_without_obstacles_is_free_everywhere() -> None:
    assert (distance_to_obstacles(free_map()) == np.inf).all()
    costmap = Costmap.from_grid(free_map(), INFLATION)
    assert (costmap.costs == 0).all()
    assert costmap.passable.all()


def test_the_costs_beside_a_wall_by_hand() -> None:
    grid = free_map(1.0, 0.3)
    grid.cells[:, 1] = OCCUPIED
    costmap = Costmap.from_grid(grid, INFLATION)
    # Centres at 0, 0.1 (inscribed), 0.2 (252 e^−0.5 = 152.8), 0.3 (56.2), 0.4 (20.7), 0.5 (7.6) and 0.6 m.
    for row in costmap.costs.tolist():
        assert row == [253, 254, 253, 152, 56, 20, 7, 0, 0, 0]
    assert costmap.passable[0].tolist() == [False] * 3 + [True] * 7
    assert costmap.costs.dtype == np.uint8


def test_unknown_cells_cost_nothing() -> None:
    grid = OccupancyGrid.filled((0.0, 0.0), (1.0, 0.1), 0.1)
    assert (grid.cells == UNKNOWN).all()
    assert (Costmap.from_grid(grid, INFLATION).costs == 0).all()


def test_costs_are_read_at_points_and_are_lethal_outside_of_the_map() -> None:
    grid = OccupancyGrid.filled((-1.0, 2.0), (0.0, 2.3), 0.1, FREE)
    grid.cells[:, 1] = OCCUPIED
    costmap = Costmap.from_grid(grid, INFLATION)
    assert costmap.cost_at([[(-0.85, 2.05), (-0.59, 2.29)]]).tolist() == [[254, 56]]
    assert int(costmap.cost_at((-0.05, 2.15))) == 0
    # The first lies left of a row, where the row before ends; the second right of one, where the next begins.
    outside = [(-1.05, 2.15), (0.05, 2.15), (-0.5, 1.95), (-0.5, 2.35), (1e6, -1e6)]
    assert costmap.cost_at(outside).tolist() == [LETHAL] * 5
    assert costmap.is_passable([(-0.59, 2.29), (-0.75, 2.05), (0.05, 2.15)]).tolist() == [True, False, False]


def test_least_cost_within_a_distance_by_hand() -> None:
    costmap = Costmap.from_grid(free_map(), INFLATION)
    # 0.1 m and a cell's diagonal: 252 exp(−10 · (0.1 + 0.1414 − 0.15)) = 101.0
    assert costmap.least_cost_within(0.1) == 101
    assert costmap.least_cost_within(0.5) == 0


def test_no_cell_near_an_obstacles_cell_costs_less_than_the_least_cost() -> None:
    grid = free_map(2.0, 2.0)
    grid.cells[9:12, 9] = OCCUPIED
    costmap = Costmap.from_grid(grid, INFLATION)
    points = np.random.default_rng(0).uniform(0.0, 2.0, (5000, 2))
    # From a point to the rectangle of those cells, x 0.9 to 1.0 and y 0.9 to 1.2 m.
    nearest = np.clip(points, (0.9, 0.9), (1.0, 1.2))
    distances = np.hypot(*(points - nearest).T)
    for reach in (0.05, 0.15, 0.25, 0.35):
        costs = costmap.cost_at(points[distances <= reach])
        assert costs.min() >= costmap.least_cost_within(reach)
        assert costmap.least_cost_within(reach) > 0
