"""The dynamic window approach: samples, arcs and each critic by hand, and what it drives towards a wall."""

import math

import numpy as np
import pytest

from asddpg.planning.costmap import Costmap, Inflation
from asddpg.planning.dwa import (
    DWA,
    DWAOptions,
    obstacle_costs,
    outline_points,
    pad,
    path_costs,
    sample_velocities,
    simulate,
)
from asddpg.planning.occupancy_grid import OCCUPIED, FloatArray, OccupancyGrid
from tests.support.fake_robot import FOOTPRINT, free_map, make_reading, make_shape, straight

INFLATION = Inflation(inscribed_radius=0.15)
OUTLINE = outline_points(FOOTPRINT, 0.04)
HERE = (2.05, 2.05, 0.0)  # a cell's centre
# From the robot straight ahead: with the goal 0.8 m away, and nearer than the forward point's 0.325 m.
FAR_PATH = straight((2.05, 2.05), (2.85, 2.05), 9)
NEAR_PATH = straight((2.05, 2.05), (2.25, 2.05), 3)


def costmap_of(grid: OccupancyGrid) -> Costmap:
    return Costmap.from_grid(grid, INFLATION)


def map_with_wall(column: int) -> OccupancyGrid:
    """4 × 4 m, the cells of a column occupied."""
    grid = free_map()
    grid.cells[:, column] = OCCUPIED
    return grid


def one_way(*poses: tuple[float, float, float]) -> FloatArray:
    """A single sample that leads over these poses."""
    return np.array([poses])


def corners(pose: tuple[float, float, float], footprint: FloatArray = FOOTPRINT) -> FloatArray:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return np.asarray(footprint @ np.array([(cos, sin), (-sin, cos)]) + pose[:2])


def arc(pose: tuple[float, float, float], v: float, omega: float, seconds: float) -> tuple[float, float, float]:
    """The exact arc, about its centre."""
    x, y, yaw = pose
    if omega == 0.0:
        return x + v * seconds * math.cos(yaw), y + v * seconds * math.sin(yaw), yaw
    radius, end = v / omega, yaw + omega * seconds
    return x + radius * (math.sin(end) - math.sin(yaw)), y - radius * (math.cos(end) - math.cos(yaw)), end


# Samples --------------------------------------------------------------------------------------------------------------


def test_the_dynamic_window_is_what_a_control_step_reaches() -> None:
    options = DWAOptions(acceleration=(0.5, 1.0), samples=(3, 3))  # in 0.2 s: 0.1 m/s and 0.2 rad/s
    sampled = sample_velocities((0.2, 0.5), make_shape(), options)
    expected = [(v, omega) for v in (0.1, 0.2, 0.3) for omega in (0.3, 0.5, 0.7)]
    np.testing.assert_allclose(sampled, expected)


def test_the_window_ends_at_the_robots_limits_and_holds_straight_ahead() -> None:
    options = DWAOptions(acceleration=(2.5, 3.2), samples=(3, 4))  # 0.5 m/s and 0.64 rad/s
    sampled = sample_velocities((0.2, 0.5), make_shape(), options)
    # v: 0, 0.25, 0.5. ω: −0.14, 0.24, 0.62, 1 and 0 between. At v = 0 only turns from 0.4 rad/s on are left.
    turns = (-0.14, 0.0, 0.24, 0.62, 1.0)
    expected = [(0.0, 0.62), (0.0, 1.0), *((v, omega) for v in (0.25, 0.5) for omega in turns)]
    np.testing.assert_allclose(sampled, expected, atol=1e-12)


def test_a_velocity_beyond_the_limits_counts_as_the_limit() -> None:
    options = DWAOptions(acceleration=(0.5, 1.0), samples=(3, 2))
    sampled = sample_velocities((0.9, -1.4), make_shape(), options)
    np.testing.assert_allclose(np.unique(sampled[:, 0]), (0.4, 0.45, 0.5))
    np.testing.assert_allclose(np.unique(sampled[:, 1]), (-1.0, -0.8))


def test_slow_samples_stay_where_there_are_no_others() -> None:
    options = DWAOptions(acceleration=(0.1, 0.5), samples=(2, 2))  # up to 0.02 m/s and 0.1 rad/s
    sampled = sample_velocities((0.0, 0.0), make_shape(), options)
    np.testing.assert_allclose(sampled, [(v, omega) for v in (0.0, 0.02) for omega in (-0.1, 0.0, 0.1)])


def test_a_sample_is_driven_along_its_exact_arc() -> None:
    sampled = np.array([(0.5, 1.0), (0.3, -0.8), (0.5, 0.0), (0.0, 0.9)])
    pose = (1.0, -2.0, 0.7)
    poses = simulate(pose, sampled, DWAOptions(sim_time=1.0))
    assert poses.shape == (4, 10, 3)  # 0.5 m at 0.05 m; 1 rad at 0.1 rad
    for index, (v, omega) in enumerate(sampled.tolist()):
        expected = [arc(pose, v, omega, 0.1 * step) for step in range(1, 11)]
        np.testing.assert_allclose(poses[index], expected, atol=1e-12)


def test_the_longest_arc_sets_the_number_of_poses() -> None:
    options = DWAOptions(sim_time=2.0, spacing=(0.1, 0.25))
    assert simulate(HERE, np.array([(0.5, 0.1)]), options).shape[1] == 10  # 1 m at 0.1 m
    assert simulate(HERE, np.array([(0.1, 1.5), (0.1, 0.0)]), options).shape[1] == 12  # 3 rad at 0.25
    assert simulate(HERE, np.array([(0.0, 0.0)]), options).tolist() == [[list(HERE)]]


# The footprint --------------------------------------------------------------------------------------------------------


def test_padding_widens_the_footprint_on_every_side() -> None:
    expected = [(0.23, -0.18), (0.23, 0.18), (-0.23, 0.18), (-0.23, -0.18)]
    np.testing.assert_allclose(pad(FOOTPRINT, 0.03), expected)
    np.testing.assert_allclose(np.abs(pad(FOOTPRINT, -0.05)), [(0.15, 0.1)] * 4)


def test_a_corner_on_an_axis_keeps_its_place_along_the_other() -> None:
    np.testing.assert_allclose(
        pad(np.array([(0.3, 0.0), (0.3, 1e-12), (0.3, -1e-12)]), 0.03), [(0.33, 0.0)] * 3, atol=1e-9
    )


def test_the_outline_has_the_corners_and_no_wide_gaps() -> None:
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    expected = [(0, 0), (0.5, 0), (1, 0), (1, 0.5), (1, 1), (0.5, 1), (0, 1), (0, 0.5)]
    np.testing.assert_allclose(outline_points(square, 0.5), expected)
    assert len(outline_points(square, 0.4)) == 12  # thirds: halves are too far apart
    gaps = np.hypot(*(OUTLINE - np.roll(OUTLINE, -1, axis=0)).T)
    assert gaps.max() <= 0.04 + 1e-12
    assert gaps.sum() == pytest.approx(1.4)  # 2 · (0.4 + 0.3) m


# The obstacle critic --------------------------------------------------------------------------------------------------


def test_the_largest_cost_on_the_way_counts() -> None:
    costmap = costmap_of(map_with_wall(20))  # centres at x = 2.05 m
    # Cells at 0.5, 0.4 and again 0.5 m: 252 e^−2.5 = 20.7 is the largest.
    assert obstacle_costs(one_way((1.55, 2.0, 0.0), (1.65, 2.0, 0.0), (1.55, 2.0, 0.0)), OUTLINE, costmap) == [20.0]
    assert obstacle_costs(one_way((0.55, 2.0, 0.0)), OUTLINE, costmap) == [0.0]


def test_a_sample_is_rejected_whose_outline_meets_an_obstacle() -> None:
    costmap = costmap_of(map_with_wall(20))  # from x = 2.0 m on; the front is 0.2 m ahead of the axis
    assert obstacle_costs(one_way((1.79, 2.0, 0.0)), OUTLINE, costmap) == [56.0]  # axis 0.3 m away: 252 e^−1.5
    assert obstacle_costs(one_way((1.81, 2.0, 0.0)), OUTLINE, costmap) == [np.inf]
    # The side is 0.15 m away, and turned by 45° a corner (0.2 + 0.15)/√2 = 0.247 m.
    assert obstacle_costs(one_way((1.84, 2.0, math.pi / 2)), OUTLINE, costmap) == [152.0]  # 252 e^−0.5
    assert obstacle_costs(one_way((1.86, 2.0, math.pi / 2)), OUTLINE, costmap) == [np.inf]
    assert obstacle_costs(one_way((1.74, 2.0, math.pi / 4)), OUTLINE, costmap) == [56.0]
    assert obstacle_costs(one_way((1.76, 2.0, math.pi / 4)), OUTLINE, costmap) == [np.inf]


def test_one_pose_on_the_way_rejects_its_sample_and_no_other() -> None:
    costmap = costmap_of(map_with_wall(20))
    poses = np.array([[(1.55, 2.0, 0.0), (0.55, 2.0, 0.0)],
                      [(1.85, 2.0, 0.0), (0.55, 2.0, 0.0)],
                      [(0.55, 2.0, 0.0), (0.65, 2.0, 0.0)]])  # fmt: skip
    costs = obstacle_costs(poses, OUTLINE, costmap)
    assert costs.tolist() == [7.0, np.inf, 0.0]  # 252 e^−3.5 = 7.6


def test_padding_keeps_the_outline_away_from_obstacles() -> None:
    costmap = costmap_of(map_with_wall(20))
    outline = outline_points(pad(FOOTPRINT, 0.03), 0.04)
    assert np.isfinite(obstacle_costs(one_way((1.76, 2.0, 0.0)), outline, costmap))
    assert obstacle_costs(one_way((1.78, 2.0, 0.0)), outline, costmap) == [np.inf]


def test_the_edge_of_the_map_is_an_obstacle() -> None:
    costmap = costmap_of(free_map())
    assert obstacle_costs(one_way((0.21, 2.0, 0.0)), OUTLINE, costmap) == [0.0]
    assert obstacle_costs(one_way((-0.1, 2.0, 0.0)), OUTLINE, costmap) == [np.inf]


def test_a_robot_turns_where_its_corners_have_the_space() -> None:
    costmap = costmap_of(map_with_wall(20))
    # Along the wall its side is 0.15 m away, its corners swing out to 0.25 m.
    along = math.pi / 2
    dwa = DWA(make_shape(), DWAOptions(paddings=(0.0,)))
    assert dwa.can_turn((1.7, 2.0, along), math.pi / 2, costmap)
    assert not dwa.can_turn((1.8, 2.0, along), math.pi / 4, costmap)
    assert dwa.can_turn((1.8, 2.0, along), 0.01, costmap)


# The critics of path and goal -----------------------------------------------------------------------------------------


def costs_of(
    *poses: tuple[float, float, float],
    path: FloatArray,
    costmap: Costmap | None = None,
    path_bias: float = 0.0,
    goal_bias: float = 0.0,
) -> list[float]:
    """Costs of samples that end at these poses, of a robot at HERE."""
    ends = np.array(poses)[:, None]
    options = DWAOptions(path_bias=path_bias, goal_bias=goal_bias)
    found: list[float] = path_costs(ends, make_reading(HERE), path, costmap or costmap_of(free_map()), options).tolist()
    return found


def test_the_path_critic_counts_metres_to_the_path() -> None:
    # Near the goal nothing else counts: 3 cells beside the path; on it; 2 cells beyond its end.
    ends = ((2.15, 2.35, 1.0), (2.15, 2.05, 0.0), (2.45, 2.05, 0.0))
    assert costs_of(*ends, path=NEAR_PATH, path_bias=1.0) == pytest.approx([0.3, 0.0, 0.2])
    assert costs_of(*ends, path=NEAR_PATH, path_bias=4.0) == pytest.approx([1.2, 0.0, 0.8])


def test_the_goal_critic_counts_metres_to_the_paths_end() -> None:
    # The goal at (2.25, 2.05): 1 and 3 cells; 1 cell; 2 cells.
    ends = ((2.15, 2.35, 1.0), (2.15, 2.05, 0.0), (2.45, 2.05, 0.0))
    assert costs_of(*ends, path=NEAR_PATH, goal_bias=1.0) == pytest.approx([0.4, 0.1, 0.2])
    assert costs_of(*ends, path=NEAR_PATH, goal_bias=4.0) == pytest.approx([1.6, 0.4, 0.8])


def test_the_alignment_critic_adds_the_distance_of_the_point_ahead_to_the_path() -> None:
    # Ends at (2.45, 2.05), on the path: facing along it; to the left, the point ahead at (2.45, 2.375), 3 cells off;
    # backwards, at (2.125, 2.05), on the path too.
    ends = ((2.45, 2.05, 0.0), (2.45, 2.05, math.pi / 2), (2.45, 2.05, math.pi))
    assert costs_of(*ends, path=FAR_PATH, path_bias=1.0) == pytest.approx([0.0, 0.3, 0.0])
    # 3 cells off, and the point ahead at (2.45, 2.675) 6 cells.
    assert costs_of((2.45, 2.35, math.pi / 2), path=FAR_PATH, path_bias=1.0) == pytest.approx([0.9])


def test_the_goal_front_critic_adds_the_distance_of_the_point_ahead_to_a_point_beyond_the_goal() -> None:
    # The goal is in column 28, the point 0.325 m beyond it at (3.175, 2.05) in column 31.
    # The first, facing the goal: 4 cells, and its point ahead at (2.775, 2.05), column 27: 4 cells.
    # The second, turned left: 4 cells, and (2.45, 2.375): 7 and 3 cells. The third, back: (2.125, 2.05): 10 cells.
    ends = ((2.45, 2.05, 0.0), (2.45, 2.05, math.pi / 2), (2.45, 2.05, math.pi))
    assert costs_of(*ends, path=FAR_PATH, goal_bias=1.0) == pytest.approx([0.8, 1.4, 1.4])


def test_near_the_goal_the_point_ahead_does_not_count() -> None:
    """There the robot may face where it likes."""
    ends = [(2.25, 2.05, yaw) for yaw in (0.0, 1.6, math.pi)]
    assert costs_of(*ends, path=NEAR_PATH, path_bias=1.0, goal_bias=1.0) == [0.0, 0.0, 0.0]


def test_the_local_goal_is_where_the_path_leaves_the_window() -> None:
    # 12 cells around column 20: up to column 32, its centre at 3.25. The end is 8 cells before it; the point beyond
    # the local goal, column 35, is outside, so that the point ahead, column 27, is rated by the same goal: 5 cells.
    # What the path does outside of the window, or behind the robot, does not count.
    ahead = straight((2.05, 2.05), (3.65, 2.05), 17)
    back = np.concatenate([straight((3.65, 2.15), (2.05, 2.15), 17), straight((2.05, 2.25), (2.05, 3.05), 9)])
    end = (2.45, 2.05, 0.0)
    for path in (ahead, np.concatenate([ahead, back]), np.concatenate([straight((0.95, 2.05), HERE[:2], 12), ahead])):
        assert costs_of(end, path=path, goal_bias=1.0) == pytest.approx([0.8 + 0.5])
    assert costs_of((2.45, 2.15, 0.0), path=np.concatenate([ahead, back]), path_bias=1.0) == pytest.approx([0.2])


def test_distances_lead_around_obstacles() -> None:
    grid = free_map()
    grid.cells[20:28, 21] = OCCUPIED
    costmap = Costmap.from_grid(grid, Inflation(inscribed_radius=0.05))  # no cell but the obstacle's own is blocked
    path = np.array([(2.05, 2.05), (2.05, 1.95), (2.15, 1.95), (2.25, 1.95), (2.25, 2.05), (2.25, 2.15), (2.25, 2.25)])
    # From row 22 of column 20 to row 22 of column 22: down to row 19 in 3 steps, 2 to the right, 3 up.
    end = (2.05, 2.25, 0.0)
    assert costs_of(end, path=path, costmap=costmap, goal_bias=1.0) == pytest.approx([0.8])
    assert costs_of(end, path=path, costmap=costmap, path_bias=1.0) == pytest.approx([0.2])


def test_an_end_in_an_impassable_cell_is_rejected_but_not_a_point_ahead_in_one() -> None:
    costmap = costmap_of(map_with_wall(26))  # columns 25 to 27 are impassable
    # Column 24 is 4 cells on; its point ahead at (2.775, 2.05) counts 0.325 m more.
    ends = ((2.55, 2.05, 0.0), (2.45, 2.05, 0.0))
    found = costs_of(*ends, path=FAR_PATH[:4], costmap=costmap, path_bias=1.0)
    assert found == pytest.approx([np.inf, 0.1])
    far = straight((2.05, 2.05), (2.45, 2.05), 5)
    assert costs_of((2.45, 2.25, 0.0), path=far, costmap=costmap, path_bias=1.0) == pytest.approx([0.2 + 0.2 + 0.325])


def test_an_end_outside_of_the_window_is_rejected() -> None:
    found = costs_of((3.25, 2.05, 0.0), (3.35, 2.05, 0.0), path=NEAR_PATH, path_bias=1.0)
    assert found == pytest.approx([1.0, np.inf])


@pytest.mark.parametrize("place", [(0.35, 0.35, 0.0), (3.65, 3.65, 0.0), (0.02, 2.05, 1.0)])
def test_the_maps_edge_cuts_the_window(place: tuple[float, float, float]) -> None:
    path = np.array([place[:2], (2.05, 2.05)])
    ends = np.array([[place]])
    options = DWAOptions(path_bias=1.0, goal_bias=0.0, forward_point=0.0)
    assert path_costs(ends, make_reading(place), path, costmap_of(free_map()), options).tolist() == [0.0]


@pytest.mark.parametrize("place", [(-1.5, 2.0, 0.0), (9.0, 9.0, 0.0), (2.0, -40.0, 0.0)])
def test_outside_of_the_map_every_sample_is_rejected(place: tuple[float, float, float]) -> None:
    assert DWA(make_shape()).choose(make_reading(place), FAR_PATH, costmap_of(free_map())) is None


# The oscillation critic -----------------------------------------------------------------------------------------------


def test_a_turn_on_the_spot_keeps_its_direction_until_the_robot_has_moved() -> None:
    dwa, costmap = DWA(make_shape(high=(0.0, 1.0))), costmap_of(free_map())  # it can do nothing but turn
    left, right = straight((2.05, 2.05), (2.05, 3.05), 11), straight((2.05, 2.05), (2.05, 1.05), 11)

    def turn(pose: tuple[float, float, float], path: FloatArray) -> float:
        command = dwa.choose(make_reading(pose), path, costmap)
        assert command is not None
        return command[1]

    assert turn(HERE, left) > 0.0
    assert turn(HERE, right) > 0.0
    assert turn((2.05, 2.05, 0.19), right) > 0.0
    assert turn((2.05, 2.05, 0.21), right) < 0.0  # more than 0.2 rad
    assert turn((2.05, 2.05, 0.21), left) < 0.0
    assert turn((2.05, 2.09, 0.21), left) < 0.0
    assert turn((2.05, 2.11, 0.21), left) > 0.0  # more than 0.05 m


def test_the_angle_turned_counts_across_half_a_turn() -> None:
    dwa, costmap = DWA(make_shape(high=(0.0, 1.0))), costmap_of(free_map())
    up, down = straight((2.05, 2.05), (2.05, 3.05), 11), straight((2.05, 2.05), (2.05, 1.05), 11)
    first = dwa.choose(make_reading((2.05, 2.05, math.pi - 0.05)), down, costmap)
    second = dwa.choose(make_reading((2.05, 2.05, -math.pi + 0.05)), up, costmap)  # 0.1 rad on
    assert first is not None
    assert second is not None
    assert first[1] > 0.0
    assert second[1] > 0.0


def test_a_turn_while_driving_may_change_its_direction_at_once() -> None:
    dwa, costmap = DWA(make_shape(low=(0.3, -1.0), high=(0.3, 1.0))), costmap_of(free_map())
    left, right = straight((2.05, 2.05), (2.05, 3.05), 11), straight((2.05, 2.05), (2.05, 1.05), 11)
    for path, sign in ((left, 1.0), (right, -1.0), (left, 1.0)):
        command = dwa.choose(make_reading(HERE), path, costmap)
        assert command is not None
        assert command[1] * sign > 0.0


# The choice -----------------------------------------------------------------------------------------------------------


def test_on_free_floor_it_drives_straight_along_its_path_at_full_speed() -> None:
    path = straight((0.55, 2.05), (3.55, 2.05), 31)
    command = DWA(make_shape()).choose(
        make_reading((0.55, 2.05, 0.0), velocity=(0.4, 0.0)), path, costmap_of(free_map())
    )
    assert command is not None
    assert command[0] == 0.5
    assert abs(command[1]) < 0.05


def test_the_obstacle_critic_outweighs_the_path_where_its_scale_is_large() -> None:
    """The path lies one row nearer to a wall than the robot."""
    grid = free_map()
    grid.cells[16] = OCCUPIED  # the path 0.3 m from it, cost 56, the robot 0.4 m, cost 20
    costmap = costmap_of(grid)
    reading = make_reading((1.05, 2.05, 0.0), velocity=(0.4, 0.0))
    largest = {}
    for scale in (0.0, 0.01, 1.0):
        command = DWA(make_shape(), DWAOptions(obstacle_scale=scale)).choose(
            reading, straight((1.05, 1.95), (3.05, 1.95), 21), costmap
        )
        assert command is not None
        way = [arc(reading.pose, *command, seconds)[:2] for seconds in np.linspace(0.0, 1.2, 50)]
        largest[scale] = int(costmap.cost_at(way).max())
    assert largest == {0.0: 56, 0.01: 56, 1.0: 20}


def test_a_critic_of_weight_0_rejects_as_before_and_counts_nothing() -> None:
    costmap = costmap_of(map_with_wall(26))
    for options in (DWAOptions(path_bias=0.0), DWAOptions(goal_bias=0.0), DWAOptions(obstacle_scale=0.0)):
        command = DWA(make_shape(), options).choose(make_reading(HERE), FAR_PATH[:4], costmap)
        assert command is not None
        assert corners(arc(HERE, *command, 1.2))[:, 0].max() < 2.6


def drive_at_wall(dwa: DWA, pose: tuple[float, float, float]) -> list[tuple[float, float, float]]:
    """Poses on the way, 8 to a command, where the path ends right before a wall that begins at x = 3.0 m."""
    costmap, velocity, way = costmap_of(map_with_wall(30)), (0.3, 0.0), [pose]
    path = straight((pose[0], 2.05), (2.95, 2.05), 20)  # its end touches the wall, and pulls
    for _ in range(20):
        command = dwa.choose(make_reading(way[-1], velocity=velocity), path, costmap)
        if command is None:
            break
        begin, velocity = way[-1], command
        way += [arc(begin, *command, 0.2 * share) for share in np.linspace(0.0, 1.0, 9)[1:]]
    return way


@pytest.mark.parametrize("gap", [0.0, 0.013, 0.05, 0.2, 0.5, 0.9])
@pytest.mark.parametrize("yaw", [0.0, 0.3])
def test_a_robot_heading_at_a_wall_never_gets_a_command_that_drives_its_padded_footprint_into_it(
    gap: float, yaw: float
) -> None:
    footprint = pad(FOOTPRINT, 0.03)
    reach = corners((0.0, 0.0, yaw), footprint)[:, 0].max()
    way = drive_at_wall(DWA(make_shape(), DWAOptions(paddings=(0.03,))), (3.0 - reach - gap - 1e-6, 2.05, yaw))
    nearest = max(corners(pose, footprint)[:, 0].max() for pose in way)
    # Only at the poses of the thought is it looked up: between two of them a corner may be a little nearer.
    assert nearest < 3.0 + 0.005
    assert gap < 0.1 or (len(way) > 1 and nearest > 2.8)


@pytest.mark.parametrize("gap", [0.0, 0.013, 0.05, 0.2, 0.5, 0.9])
def test_smaller_paddings_bring_the_footprint_no_farther_into_the_wall_than_they_narrow_it(gap: float) -> None:
    way = drive_at_wall(DWA(make_shape()), (2.77 - gap - 1e-6, 2.05, 0.0))
    nearest = max(corners(pose)[:, 0].max() for pose in way)
    assert nearest < 3.0 + 0.03 + 0.005
    assert gap < 0.1 or (len(way) > 1 and nearest > 2.8)


def test_with_the_footprint_on_an_obstacles_cell_a_smaller_padding_lets_it_get_away() -> None:
    grid = free_map()
    grid.cells[22] = OCCUPIED  # y from 2.2 m on; the robot's side is at 2.06 + 0.15 = 2.21 m, padded by −0.03 at 2.18
    path = np.concatenate([straight((1.05, 2.06), (2.05, 1.06), 11), straight((2.15, 1.06), (3.05, 1.06), 10)])
    reading = make_reading((1.05, 2.06, 0.0))
    costmap = costmap_of(grid)
    assert DWA(make_shape(), DWAOptions(paddings=(0.03,))).choose(reading, path, costmap) is None
    assert DWA(make_shape(), DWAOptions(paddings=(0.03, 0.0))).choose(reading, path, costmap) is None
    command = DWA(make_shape()).choose(reading, path, costmap)
    assert command is not None
    assert command[0] > 0.0
    end = arc(reading.pose, *command, 1.2)
    assert corners(end, pad(FOOTPRINT, -0.03))[:, 1].max() < 2.2


def test_a_larger_padding_that_leaves_a_sample_decides() -> None:
    costmap = costmap_of(map_with_wall(30))  # from x = 3.0 m on
    shape = make_shape(low=(0.3, 0.0), high=(0.5, 0.0))  # straight ahead, slowly or fast
    # At 0.5 m/s the front is at 2.19 + 0.2 + 0.6 = 2.99 m in the end, and nearer to the goal; padded it is in the wall.
    path = straight((2.25, 2.05), (2.85, 2.05), 7)
    reading = make_reading((2.19, 2.05, 0.0), velocity=(0.4, 0.0))
    for paddings, speed in (((0.03, 0.0), 0.3), ((0.03,), 0.3), ((0.0,), 0.5)):
        options = DWAOptions(samples=(2, 2), obstacle_scale=0.0, forward_point=0.0, paddings=paddings)
        assert DWA(shape, options).choose(reading, path, costmap) == (speed, 0.0)


def test_less_than_the_footprint_counts_only_on_an_obstacles_cell() -> None:
    costmap = costmap_of(map_with_wall(30))  # from x = 3.0 m on
    shape = make_shape(low=(0.3, 0.0), high=(0.5, 0.0))  # it cannot but drive on
    path = straight((2.25, 2.05), (2.85, 2.05), 7)
    for x, drives in ((2.78, False), (2.82, True)):  # its front at 2.98 m, or at 3.02 m, in the wall
        options = DWAOptions(samples=(1, 1), sim_time=0.1, paddings=(0.03, 0.0, -0.06))
        found = DWA(shape, options).choose(make_reading((x, 2.05, 0.0), velocity=(0.3, 0.0)), path, costmap)
        assert (found is not None) == drives


def test_enclosed_it_has_no_command() -> None:
    grid = free_map()
    grid.cells[17:24, 17:24] = OCCUPIED
    grid.cells[20, 20] = 0
    assert DWA(make_shape()).choose(make_reading(HERE), FAR_PATH, costmap_of(grid)) is None
