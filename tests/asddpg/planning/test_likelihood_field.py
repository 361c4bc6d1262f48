"""The likelihood field and the weights of scans, against cases worked out by hand."""

import math

import numpy as np
import pytest

from asddpg.planning.likelihood_field import LaserOptions, LikelihoodField, LikelihoodModel, evenly_spaced
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, OccupancyGrid

WALL = 2.05  # x of the wall, m
HIT = 0.95 + 0.05 / 5.6  # probability density of a beam that ends in it
HIT_AT_SIGMA = 0.95 * math.exp(-0.5) + 0.05 / 5.6


@pytest.fixture
def grid() -> OccupancyGrid:
    """A room of 5 m by 3 m, its corner at (0, −1), with a wall across it."""
    grid = OccupancyGrid.filled((0.0, -1.0), (5.0, 2.0), 0.1, FREE)
    grid.cells[:, 20] = OCCUPIED
    return grid


@pytest.fixture
def field(grid: OccupancyGrid) -> LikelihoodField:
    return LikelihoodField(grid)


def test_distance_to_a_wall(field: LikelihoodField) -> None:
    points = np.array([[(WALL, 0.0), (WALL + 0.3, 1.9)], [(WALL - 0.7, -0.95), (WALL + 1.9, 0.0)]])
    np.testing.assert_allclose(field.distances_at(points), [[0.0, 0.3], [0.7, 1.9]], rtol=1e-6)


def test_distances_are_cut_far_away_and_outside_the_map(field: LikelihoodField) -> None:
    points = [(4.95, 0.0), (WALL, 2.05), (WALL, -1.05), (-0.05, 0.0), (5.05, 0.0), (1e12, -1e12)]
    assert field.distances_at(points).tolist() == [2.0] * 6
    assert field.distances_at((0.05, 0.0)) == pytest.approx(2.0)
    assert field.distances_at((0.15, 0.0)) == pytest.approx(1.9)


def test_distance_to_a_lone_cell_is_euclidean() -> None:
    grid = OccupancyGrid.filled((0.0, 0.0), (1.0, 1.0), 0.1, FREE)
    grid.cells[2, 1] = OCCUPIED  # row along y
    assert LikelihoodField(grid).distances_at((0.45, 0.65)) == pytest.approx(0.5)
    assert LikelihoodField(grid, 0.4).distances_at((0.45, 0.65)) == pytest.approx(0.4)


def test_a_map_without_obstacles_is_far_from_all() -> None:
    grid = OccupancyGrid.filled((0.0, 0.0), (1.0, 1.0), 0.1, FREE)
    assert (LikelihoodField(grid, 1.5).distances == 1.5).all()


def test_probability_of_a_beam_by_hand(grid: OccupancyGrid) -> None:
    found = LikelihoodModel(grid, 5.6).beam_probability([0.0, 0.2, 2.0])
    assert found == pytest.approx([0.9589286, 0.5851327, 0.0089286], abs=1e-7)


def test_weights_of_two_poses_by_hand(grid: OccupancyGrid) -> None:
    lasers = np.array([(WALL - 1.0, 0.0, 0.0), (WALL - 1.2, 0.0, 0.0), (0.5, WALL - 1.5, math.pi)])
    ranges, angles = (1.0, 1.25), (0.0, math.acos(0.8))  # both end 1 m ahead of the laser
    weights = LikelihoodModel(grid, 5.6).weights(lasers, ranges, angles)
    assert weights[:2] == pytest.approx([1 + 2 * HIT**3, 1 + 2 * HIT_AT_SIGMA**3], rel=1e-6)
    assert weights[2] == pytest.approx(1.0, abs=1e-5)


def test_beams_turn_with_the_pose(grid: OccupancyGrid) -> None:
    lasers = np.array([(WALL - 0.8, 0.6, -0.5), (WALL + 0.8, 0.6, 1.0 + math.pi)])
    model = LikelihoodModel(grid, 5.6)
    assert model.weights(lasers, [0.8], [0.5])[0] == pytest.approx(1 + HIT**3, rel=1e-6)
    assert model.weights(lasers, [0.8], [-1.0])[1] == pytest.approx(1 + HIT**3, rel=1e-6)


def test_beams_without_an_echo_are_left_out(grid: OccupancyGrid) -> None:
    model = LikelihoodModel(grid, 5.6)
    laser = np.array([(WALL - 1.0, 0.0, 0.0)])
    ranges = [math.inf, math.nan, 5.6, -1.0, 0.0, -math.inf]
    assert model.weights(laser, ranges, np.zeros(6)).tolist() == [1.0]
    assert model.weights(laser, [*ranges, 1.0], np.zeros(7)) == pytest.approx([1 + HIT**3], rel=1e-6)
    assert model.weights(laser, [], []).tolist() == [1.0]


def test_a_scan_is_thinned_evenly(grid: OccupancyGrid) -> None:
    laser = np.array([(WALL - 1.0, 0.0, 0.0)])
    weight = LikelihoodModel(grid, 5.6, LaserOptions(max_beams=30)).weights(laser, np.full(40, 1.0), np.zeros(40))
    assert weight == pytest.approx([1 + 30 * HIT**3], rel=1e-6)
    assert evenly_spaced(9, 3).tolist() == [0, 4, 8]
    assert evenly_spaced(3, 30).tolist() == [0, 1, 2]
    assert set(np.diff(evenly_spaced(40, 30))) == {1, 2}


def test_a_product_of_two_beams_by_hand(grid: OccupancyGrid) -> None:
    lasers = np.array([(WALL - 1.0, 0.0, 0.0), (WALL - 1.2, 0.0, 0.0)])
    ranges, angles = (1.0, 1.25), (0.0, math.acos(0.8))  # both end 1 m ahead of the laser
    independent = LikelihoodModel(grid, 5.6, LaserOptions(beam_power=1.0)).weights(lasers, ranges, angles)
    assert independent == pytest.approx([HIT**2, HIT_AT_SIGMA**2], rel=1e-6)
    alike = LikelihoodModel(grid, 5.6, LaserOptions(beam_power=0.5)).weights(lasers, ranges, angles)
    assert alike == pytest.approx([HIT, HIT_AT_SIGMA], rel=1e-6)


def test_many_wrong_beams_leave_a_weight(grid: OccupancyGrid) -> None:
    model = LikelihoodModel(grid, 5.6, LaserOptions(beam_power=1.0, max_beams=1000))
    assert model.weights(np.array([(0.5, 0.0, math.pi)]), np.full(1000, 0.3), np.zeros(1000))[0] > 0.0
