"""The map built from scans: each cell's log-odds by hand."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from asddpg.planning.log_odds_map import LogOddsMap, LogOddsOptions
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

MAX_RANGE = 5.0
ROW = (0.05, 0.25, 0.0)  # the centre of row 2's first cell, facing along the row
CLEAR = LogOddsOptions(miss=-0.4)


@pytest.fixture
def found() -> LogOddsMap:
    """10 × 5 cells of 0.1 m, the lowest corner at the origin."""
    return LogOddsMap(OccupancyGrid.filled((0.0, 0.0), (1.0, 0.5), 0.1), CLEAR)


def insert(
    into: LogOddsMap,
    ranges: Sequence[float],
    pose: tuple[float, float, float] = ROW,
    beams: Sequence[float] | None = None,
    laser: tuple[float, float] = (0.0, 0.0),
) -> None:
    directions = np.zeros(len(ranges)) if beams is None else np.array(beams)
    into.insert(pose, np.array(ranges), directions, laser, MAX_RANGE)


def test_nothing_is_known_in_the_beginning(found: LogOddsMap) -> None:
    assert (found.grid.cells == UNKNOWN).all()
    assert (found.grid.shape, found.grid.resolution, found.grid.origin) == ((5, 10), 0.1, (0.0, 0.0))


def test_the_layouts_own_obstacles_are_not_taken_over() -> None:
    layout = OccupancyGrid.filled((-1.0, -1.0), (0.0, 0.0), 0.1, OCCUPIED)
    assert (LogOddsMap(layout).grid.cells == UNKNOWN).all()
    assert LogOddsMap(layout).grid.origin == (-1.0, -1.0)


def test_a_beam_frees_what_it_passes_and_occupies_where_it_ends(found: LogOddsMap) -> None:
    insert(found, [0.5])  # it ends at x = 0.55
    # 1/(1 + e^0.4) = 0.401 and 1/(1 + e^−0.85) = 0.701
    assert found.grid.cells[2].tolist() == [40] * 5 + [70] + [UNKNOWN] * 4
    assert (found.grid.cells[[0, 1, 3, 4]] == UNKNOWN).all()
    assert found.grid.occupied[2].tolist() == [False] * 5 + [True] + [False] * 4


def test_scans_add_up(found: LogOddsMap) -> None:
    insert(found, [0.5])
    insert(found, [0.5])
    # −0.8: 1/(1 + e^0.8) = 0.310; 1.7: 1/(1 + e^−1.7) = 0.846
    assert found.grid.cells[2, :6].tolist() == [31] * 5 + [85]


def test_a_later_beam_through_an_obstacle_frees_its_cell_again(found: LogOddsMap) -> None:
    insert(found, [0.5])
    insert(found, [0.8])
    # 0.85 − 0.4 = 0.45: 0.611, below the threshold of 65
    assert found.grid.cells[2].tolist() == [31] * 5 + [61, 40, 40, 70, UNKNOWN]
    assert not found.grid.occupied[2, 5]


def test_the_sum_is_limited_so_that_what_has_moved_is_soon_seen(found: LogOddsMap) -> None:
    for _ in range(20):
        insert(found, [0.5])
    assert found.grid.cells[2, :6].tolist() == [3] * 5 + [97]  # ∓3.5: 1/(1 + e^±3.5) = 0.029 and 0.971
    for count in range(1, 9):
        insert(found, [0.8])
        # 3.5 − 0.4 · 8 = 0.3; it is free below ln(0.645/0.355) = 0.597
        assert found.grid.occupied[2, 5] == (count < 8)


def test_own_options_count() -> None:
    found = LogOddsMap(OccupancyGrid.filled((0.0, 0.0), (1.0, 0.5), 0.1), LogOddsOptions(2.0, -1.0, 2.5))
    insert(found, [0.5])
    assert found.grid.cells[2, 4:6].tolist() == [27, 88]  # 1/(1 + e^1), 1/(1 + e^−2)
    insert(found, [0.5])
    assert found.grid.cells[2, 4:6].tolist() == [12, 92]  # −2; 4 cut to 2.5


@pytest.mark.parametrize("nothing", [math.inf, MAX_RANGE, MAX_RANGE + 1.0])
def test_a_beam_without_a_return_occupies_nothing(found: LogOddsMap, nothing: float) -> None:
    insert(found, [nothing])
    assert found.grid.cells[2].tolist() == [40] * 10
    assert not found.grid.occupied.any()


def test_a_beam_without_a_return_has_passed_as_far_as_the_laser_sees() -> None:
    found = LogOddsMap(OccupancyGrid.filled((0.0, 0.0), (1.0, 0.1), 0.1), CLEAR)
    found.insert((0.05, 0.05, 0.0), np.array([math.inf]), np.array([0.0]), (0.0, 0.0), 0.5)
    assert found.grid.cells[0].tolist() == [40] * 6 + [UNKNOWN] * 4  # up to x = 0.55


def test_several_beams_that_end_in_one_cell_count_once_but_each_clears(found: LogOddsMap) -> None:
    insert(found, [0.5, 0.5, 0.52])
    # −1.2: 1/(1 + e^1.2) = 0.231
    assert found.grid.cells[2, :6].tolist() == [23] * 5 + [70]


def test_a_cell_that_one_beam_ends_in_is_not_cleared_by_another_of_the_same_scan(found: LogOddsMap) -> None:
    insert(found, [0.3, 0.5])
    # Two beams up to column 2, one through column 4, and in column 3 the end of one counts alone.
    assert found.grid.cells[2, :7].tolist() == [31, 31, 31, 70, 40, 70, UNKNOWN]


def test_beams_turn_with_the_robot_about_its_laser(found: LogOddsMap) -> None:
    # Facing along y from (0.25, 0.05): the laser, 0.1 m ahead and 0.1 m to the left, is at (0.15, 0.15).
    pose = (0.25, 0.05, math.pi / 2)
    insert(found, [0.2, 0.6], pose, beams=(0.0, -math.pi / 2), laser=(0.1, 0.1))
    cells = found.grid.cells
    assert cells[3, 1] == 70  # ahead: (0.15, 0.35)
    assert cells[2, 1] == 40
    assert cells[1].tolist() == [UNKNOWN, 31, *[40] * 5, 70, UNKNOWN, UNKNOWN]  # to the right: (0.75, 0.15)
    assert int((cells != UNKNOWN).sum()) == 9


def test_an_oblique_beam_frees_the_cells_on_its_way_once() -> None:
    found = LogOddsMap(OccupancyGrid.filled((0.0, 0.0), (1.0, 1.0), 0.1), CLEAR)
    insert(found, [0.5], (0.05, 0.055, 0.0), beams=(math.atan2(3.0, 4.0),))  # to (0.45, 0.355)
    cells = found.grid.cells
    assert cells[3, 4] == 70
    # Every 0.05 m: (0.05, 0.055), (0.09, 0.085), (0.13, 0.115), (0.17, 0.145), (0.21, 0.175), (0.25, 0.205), …
    assert np.argwhere(cells == 40).tolist() == [[0, 0], [1, 1], [1, 2], [2, 2], [2, 3]]
    assert int((cells != UNKNOWN).sum()) == 6


def test_what_lies_outside_of_the_map_is_left_out(found: LogOddsMap) -> None:
    insert(found, [3.0, 0.4, 0.5], beams=(0.0, math.pi / 2, math.pi))
    # Ahead the beam leaves the map; to the left it ends at y = 0.65, beyond it; backwards it leaves at once.
    assert found.grid.cells[2].tolist() == [23] + [40] * 9
    assert found.grid.cells[:, 0].tolist() == [UNKNOWN, UNKNOWN, 23, 40, 40]
    assert not found.grid.occupied.any()
    insert(found, [0.5], (-0.45, 0.25, 0.0))  # a robot outside that sees the map's first cell
    assert found.grid.cells[2, 0] == 41  # −1.2 + 0.85 = −0.35


def test_clearing_forgets_all_scans(found: LogOddsMap) -> None:
    insert(found, [0.5])
    found.clear()
    assert (found.grid.cells == UNKNOWN).all()
    insert(found, [0.5])
    assert found.grid.cells[2, :6].tolist() == [40] * 5 + [70]


def test_a_grid_once_handed_out_stays_as_it_was(found: LogOddsMap) -> None:
    insert(found, [0.5])
    before = found.grid
    insert(found, [0.8])
    assert before.occupied[2, 5]
    assert FREE <= found.grid.cells[2, 5] < 65
