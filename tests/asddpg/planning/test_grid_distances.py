"""Distances over a grid, against mazes counted by hand and a plain search."""

from collections import deque

import numpy as np
import pytest

from asddpg.planning.grid_distances import grid_distances
from asddpg.planning.occupancy_grid import BoolArray, FloatArray
from tests.support.fake_robot import drawn

INF = np.inf


def search(blocked: BoolArray, seeds: list[tuple[int, int]]) -> FloatArray:
    """Cell by cell."""
    found = np.full(blocked.shape, INF)
    queue = deque(seeds)
    for seed in seeds:
        found[seed] = 0.0
    while queue:
        row, column = queue.popleft()
        for there in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1)):
            is_inside = 0 <= there[0] < blocked.shape[0] and 0 <= there[1] < blocked.shape[1]
            if is_inside and not blocked[there] and found[there] == INF:
                found[there] = found[row, column] + 1.0
                queue.append(there)
    return found


def test_steps_lead_around_a_wall() -> None:
    blocked = drawn("..#.",
                    ".##.",
                    "....")  # fmt: skip
    assert grid_distances(blocked, np.array([(0, 0)])).tolist() == [[0, 1, INF, 7], [1, INF, INF, 6], [2, 3, 4, 5]]


def test_a_diagonal_neighbour_is_two_steps_away() -> None:
    found = grid_distances(np.zeros((3, 3), dtype=bool), np.array([(1, 1)]))
    assert found.tolist() == [[2, 1, 2], [1, 0, 1], [2, 1, 2]]


def test_the_nearest_of_several_seeds_counts() -> None:
    found = grid_distances(drawn("......"), np.array([(0, 0), (0, 4), (0, 0)]))
    assert found.tolist() == [[0, 1, 2, 1, 0, 1]]


def test_a_blocked_seed_counts_and_no_way_leads_through_other_blocked_cells() -> None:
    found = grid_distances(drawn("#.#.",
                                 "..##"), np.array([(0, 0)]))  # fmt: skip
    assert found.tolist() == [[0, 1, INF, INF], [1, 2, INF, INF]]


def test_nothing_is_reached_across_the_edge_of_the_grid() -> None:
    """Cells of one row's end and of the next one's beginning lie side by side in memory."""
    found = grid_distances(drawn(".#.",
                                 "##.",
                                 ".#."), np.array([(0, 2)]))  # fmt: skip
    assert found.tolist() == [[INF, INF, 0], [INF, INF, 1], [INF, INF, 2]]


def test_without_seeds_nothing_is_reached() -> None:
    assert (grid_distances(drawn("..", ".."), np.zeros((0, 2), dtype=np.intp)) == INF).all()


@pytest.mark.parametrize("density", [0.1, 0.3, 0.5])
def test_random_mazes_agree_with_a_plain_search(density: float) -> None:
    rng = np.random.default_rng(7)
    for _ in range(10):
        blocked = rng.uniform(size=(17, 23)) < density
        seeds = np.stack([rng.integers(17, size=4), rng.integers(23, size=4)], axis=1)
        expected = search(blocked, [(row, column) for row, column in seeds.tolist()])
        np.testing.assert_array_equal(grid_distances(blocked, seeds), expected)
