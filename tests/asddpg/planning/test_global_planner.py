"""The global planner, in maps whose only or cheapest way is plain."""

import numpy as np
import pytest

from asddpg.planning import global_planner
from asddpg.planning.costmap import Costmap, Inflation
from asddpg.planning.global_planner import nearest_index, plan_path, point_ahead
from asddpg.planning.occupancy_grid import OCCUPIED, FloatArray, OccupancyGrid
from tests.support.fake_robot import free_map, map_with_gap

INFLATION = Inflation(inscribed_radius=0.15)
CORNER = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])


def costmap_of(grid: OccupancyGrid) -> Costmap:
    return Costmap.from_grid(grid, INFLATION)


def planned(costmap: Costmap, start: tuple[float, float], goal: tuple[float, float]) -> FloatArray:
    path = plan_path(costmap, start, goal)
    assert path is not None
    return path


def length(path: FloatArray) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def test_on_a_free_map_the_path_is_straight_cell_by_cell() -> None:
    path = planned(costmap_of(free_map()), (1.05, 2.05), (2.05, 2.05))
    np.testing.assert_allclose(path, [(1.05 + 0.1 * index, 2.05) for index in range(11)], atol=1e-12)


def test_the_path_goes_diagonally_too() -> None:
    path = planned(costmap_of(free_map()), (1.05, 3.05), (2.05, 2.05))
    np.testing.assert_allclose(path, [(1.05 + 0.1 * index, 3.05 - 0.1 * index) for index in range(11)], atol=1e-12)


def test_the_path_begins_in_the_starts_cell_and_ends_at_the_goal() -> None:
    path = planned(costmap_of(free_map()), (1.02, 2.09), (2.01, 2.72))
    assert path[0] == pytest.approx((1.05, 2.05))
    assert path[-1] == pytest.approx((2.01, 2.72))
    assert planned(costmap_of(free_map()), (1.02, 2.09), (1.08, 2.01)).tolist() == [[1.08, 2.01]]  # of the same cell


def test_a_path_leads_around_a_wall_through_its_only_gap() -> None:
    costmap = costmap_of(map_with_gap())
    path = planned(costmap, (0.55, 0.55), (3.55, 0.55))
    crossing = np.interp(2.05, path[:, 0], path[:, 1])
    assert 3.15 < crossing < 3.65  # the gap, y from 3.0 to 3.8 m, less the inscribed radius
    assert costmap.is_passable(path).all()
    assert (np.hypot(*np.diff(path, axis=0).T) < 0.25).all()  # neighbours, smoothed or not
    assert length(path) > 5.5  # 2 √(1.5² + 2.6²) = 6.0 m by the straightest way through the gap's lower end


def test_no_path_leads_through_a_closed_wall() -> None:
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    assert plan_path(costmap_of(grid), (0.55, 0.55), (3.55, 0.55)) is None
    assert plan_path(costmap_of(grid), (0.55, 0.55), (1.55, 0.55)) is not None


def test_no_path_leads_through_a_gap_narrower_than_the_robot() -> None:
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    grid.cells[30:32, 20] = 0  # 0.2 m, and the robot is 0.3 m wide
    assert plan_path(costmap_of(grid), (0.55, 0.55), (3.55, 0.55)) is None


def test_a_goal_too_near_to_a_wall_is_replaced_by_the_nearest_place_to_stand() -> None:
    grid = free_map()
    grid.cells[:, 30] = OCCUPIED  # x from 3.0 to 3.1 m; column 29 is inscribed, 28 the first passable one
    path = planned(costmap_of(grid), (1.05, 2.05), (2.98, 2.06))
    assert path[-1] == pytest.approx((2.85, 2.05))


def test_a_goal_that_is_out_of_reach_has_no_path() -> None:
    grid = free_map()
    grid.cells[:, 20:30] = OCCUPIED  # x from 2.0 to 3.0 m; 1.85 is the last place to stand
    assert plan_path(costmap_of(grid), (1.05, 2.05), (2.14, 2.05)) is not None  # 0.29 m from it
    assert plan_path(costmap_of(grid), (1.05, 2.05), (2.16, 2.05)) is None  # 0.31 m


def test_a_start_in_an_impassable_cell_may_be_left() -> None:
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    path = planned(costmap_of(grid), (1.95, 2.05), (0.55, 2.05))
    assert path[0] == pytest.approx((1.85, 2.05))
    assert path[-1] == pytest.approx((0.55, 2.05))
    wide = free_map()
    wide.cells[15:26, 15:26] = OCCUPIED
    assert plan_path(costmap_of(wide), (2.05, 2.05), (0.55, 2.05)) is None


def test_a_start_or_goal_outside_of_the_map_counts_as_its_edge_or_has_no_path() -> None:
    costmap = costmap_of(free_map())
    assert planned(costmap, (-0.2, 1.05), (1.05, 1.05))[0] == pytest.approx((0.05, 1.05))  # 0.25 m away
    assert planned(costmap, (1.05, 1.05), (4.2, 1.05))[-1] == pytest.approx((3.95, 1.05))
    assert plan_path(costmap, (-0.4, 1.05), (1.05, 1.05)) is None
    assert plan_path(costmap, (1.05, 1.05), (40.0, -30.0)) is None


def test_the_path_keeps_off_a_wall_where_the_detour_is_cheaper() -> None:
    grid = free_map()
    grid.cells[0] = OCCUPIED
    path = planned(costmap_of(grid), (0.25, 0.35), (3.75, 0.35))  # 0.3 m from the wall's cells
    # A cell at 0.3 m costs 50 + 0.8 · 56 = 94.8, at 0.4 m 50 + 0.8 · 20 = 66, at 0.5 m 55.6 and at 0.6 m 50. Over 35
    # cells a diagonal step to either side and back is soon regained: at 0.6 m the whole way costs least.
    assert path[len(path) // 2, 1] == pytest.approx(0.65)


def test_the_path_takes_the_wall_where_the_detour_costs_more() -> None:
    grid = free_map()
    grid.cells[0] = OCCUPIED
    path = planned(costmap_of(grid), (0.25, 0.55), (0.45, 0.55))
    # Two cells at 0.5 m cost 2 · (50 + 0.8 · 7) = 111; a diagonal up and one down, at 0.6 m, √2 · (55.6 + 50) = 149.
    np.testing.assert_allclose(path[:, 1], 0.55)


@pytest.fixture
def smooths_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(global_planner, "PASSES", 1)


@pytest.mark.usefixtures("smooths_once")
def test_smoothing_averages_over_a_window_that_shrinks_towards_the_ends() -> None:
    path = np.array([(1.05, 1.05), (1.15, 1.05), (1.25, 1.05), (1.25, 1.15), (1.25, 1.25)])
    smoothed = global_planner._smooth(costmap_of(free_map()), path)
    # 0.25 m to either side are 2 cells: windows of 1, 3, 5, 3 and 1 points
    expected = [(1.05, 1.05), (1.15, 1.05), (1.19, 1.11), (1.25, 1.15), (1.25, 1.25)]
    np.testing.assert_allclose(smoothed, expected, atol=1e-12)


def test_smoothing_brings_the_path_nowhere_nearer_to_an_obstacle_than_its_margin(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Cells at random leave many narrow passages."""
    rng, differs = np.random.default_rng(3), 0
    for _ in range(10):
        grid = free_map()
        grid.cells[rng.uniform(size=grid.shape) < 0.025] = OCCUPIED
        costmap = costmap_of(grid)
        monkeypatch.setattr(global_planner, "SMOOTHING", 0.5)
        smoothed = plan_path(costmap, (0.25, 0.25), (3.75, 3.75))
        monkeypatch.setattr(global_planner, "SMOOTHING", 0.0)
        raw = plan_path(costmap, (0.25, 0.25), (3.75, 3.75))
        if smoothed is None or raw is None:
            continue
        allowed = costmap.inflation.cost(costmap.inflation.inscribed_radius + global_planner.SMOOTHING_MARGIN)
        assert (costmap.cost_at(smoothed) <= np.maximum(costmap.cost_at(raw), allowed)).all()
        assert smoothed[0] == pytest.approx(raw[0])
        assert smoothed[-1] == pytest.approx(raw[-1])
        differs += int(np.hypot(*(smoothed - raw).T).max() > 0.02)
    assert differs >= 5


@pytest.mark.usefixtures("smooths_once")
def test_a_point_that_smoothing_would_move_to_a_dearer_cell_stays() -> None:
    grid = free_map()
    grid.cells[12, 11] = OCCUPIED  # inside of the corner, its centre at (1.15, 1.25)
    costmap = Costmap.from_grid(grid, Inflation(inscribed_radius=0.05))
    path = np.array([(1.05, 1.05), (1.15, 1.05), (1.25, 1.05), (1.35, 1.05), (1.35, 1.15), (1.35, 1.25), (1.35, 1.35)])
    smoothed = global_planner._smooth(costmap, path)
    # The corner's window is of 5 points: (1.29, 1.11), in the cell of (1.25, 1.15), nearer to the obstacle.
    assert smoothed[3] == pytest.approx((1.35, 1.05))
    free = global_planner._smooth(costmap_of(free_map()), path)
    assert free[3] == pytest.approx((1.29, 1.11))


def test_the_nearest_point_of_a_path() -> None:
    assert nearest_index(CORNER, (0.9, -0.2)) == 1
    assert nearest_index(CORNER, (-3.0, 0.1)) == 0
    assert nearest_index(CORNER, (1.1, 7.0)) == 2


@pytest.mark.parametrize(
    ("position", "distance", "expected"),
    [
        ((0.9, -0.2), 0.4, (1.0, 0.4)),  # from the corner
        ((0.0, 0.1), 0.4, (0.4, 0.0)),
        ((0.0, 0.1), 1.5, (1.0, 0.5)),  # around it
        ((0.0, 0.1), 0.0, (0.0, 0.0)),
        ((0.9, -0.2), 5.0, (1.0, 1.0)),  # beyond the end
        ((1.0, 2.0), 0.5, (1.0, 1.0)),
    ],
)
def test_a_point_ahead_lies_along_the_path(
    position: tuple[float, float], distance: float, expected: tuple[float, float]
) -> None:
    assert point_ahead(CORNER, position, distance) == pytest.approx(expected)


def test_a_path_of_one_point_has_that_point_ahead() -> None:
    assert point_ahead(np.array([(2.0, 3.0)]), (0.0, 0.0), 1.0) == (2.0, 3.0)
