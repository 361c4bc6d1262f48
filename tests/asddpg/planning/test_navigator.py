"""Navigator, MoveBase and WaypointDriver, with a robot that is where the test says."""

import math
from collections.abc import Mapping

import numpy as np
import pytest

from asddpg.episodes.protocols import Decision, Driver, Observation, Step
from asddpg.planning.costmap import Costmap, Inflation
from asddpg.planning.dwa import DWAOptions
from asddpg.planning.move_base import MoveBase
from asddpg.planning.navigator import Navigator, NavigatorOptions
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, FloatArray, OccupancyGrid
from asddpg.planning.robot import Reading
from asddpg.planning.waypoints import WaypointDriver, with_goal
from tests.support.fake_robot import FOOTPRINT, FakeRobot, free_map, make_reading, make_shape, map_with_gap

OBSERVATION: Observation = np.linspace(-0.5, 0.5, 10).astype(np.float32)
START, GOAL = (0.55, 2.05, 0.0), (3.55, 2.05)
NO_WAY = DWAOptions(paddings=())  # DWA without an outline to try finds nothing


def path_of(navigator: Navigator | None) -> FloatArray:
    assert navigator is not None
    assert navigator.path is not None
    return navigator.path


def is_occupied(navigator: Navigator, point: tuple[float, float]) -> bool:
    row, column = navigator.costmap.grid.to_cells(point).tolist()
    return bool(navigator.costmap.grid.occupied[row, column])


# Navigator ------------------------------------------------------------------------------------------------------------


def test_the_known_map_is_planned_on() -> None:
    reading = make_reading((0.55, 0.55, 0.0), (3.55, 0.55))
    robot = FakeRobot(map_with_gap(), reading)
    navigator = Navigator(robot, NavigatorOptions(), reading)
    assert navigator.path is None
    navigator.update(reading)
    assert 3.15 < float(np.interp(2.05, path_of(navigator)[:, 0], path_of(navigator)[:, 1])) < 3.65  # the gap
    expected = Costmap.from_grid(map_with_gap(), Inflation(0.15, 0.55, 10.0))
    assert (navigator.costmap.costs == expected.costs).all()


def test_the_inflation_is_that_of_the_options_and_of_the_robot() -> None:
    reading = make_reading(START, GOAL)
    options = NavigatorOptions(inflation_radius=0.4, cost_scaling=3.0)
    navigator = Navigator(FakeRobot(map_with_gap(), reading), options, reading)
    assert navigator.costmap.inflation == Inflation(0.15, 0.4, 3.0)


def test_an_unmapped_obstacle_is_added_to_the_map_and_goes_away_when_cleared() -> None:
    robot = FakeRobot(map_with_gap(), make_reading(START, GOAL, [1.0]))  # it sees something at (1.55, 2.05)
    navigator = Navigator(robot, NavigatorOptions(), robot.reading)
    assert not is_occupied(navigator, (1.55, 2.05))
    navigator.update(robot.reading)
    assert is_occupied(navigator, (1.55, 2.05))
    assert is_occupied(navigator, (2.05, 2.05))  # the wall of the map behind it
    assert not navigator.costmap.is_passable((1.45, 2.05))
    assert np.hypot(*(path_of(navigator) - (1.55, 2.05)).T).min() > 0.15
    navigator.clear()
    assert not is_occupied(navigator, (1.55, 2.05))
    assert is_occupied(navigator, (2.05, 2.05))
    assert navigator.costmap.is_passable((1.45, 2.05))


SEEN_THROUGH = 3  # scans that outweigh one hit: 0.85 − 0.3 is 63 %, no longer an obstacle


def test_what_the_laser_sees_through_goes_away_but_not_from_the_map() -> None:
    robot = FakeRobot(map_with_gap(), make_reading(START, GOAL, [1.0]))
    navigator = Navigator(robot, NavigatorOptions(), robot.reading)
    navigator.update(robot.reading)
    robot.reading = make_reading(START, GOAL, [3.0])  # through both
    for _ in range(SEEN_THROUGH):
        navigator.update(robot.reading)
    assert not is_occupied(navigator, (1.55, 2.05))
    assert is_occupied(navigator, (2.05, 2.05))


def test_without_scans_only_the_map_counts() -> None:
    reading = make_reading(START, GOAL, [1.0])
    navigator = Navigator(FakeRobot(free_map(), reading), NavigatorOptions(uses_scans=False), reading)
    navigator.update(reading)
    assert not navigator.costmap.grid.occupied.any()


@pytest.mark.parametrize("grid", [None, map_with_gap()])
def test_without_a_map_it_begins_with_nothing_known(grid: OccupancyGrid | None) -> None:
    reading = make_reading((1.0, -2.0, 0.0), (4.0, 3.0), [1.0])
    navigator = Navigator(FakeRobot(grid, reading), NavigatorOptions(uses_map=False), reading)
    found = navigator.costmap.grid
    assert (found.cells == UNKNOWN).all()
    # 8 m beyond robot and goal: x from −7 to 12, y from −10 to 11 m, in cells of 0.05 m
    assert found.origin == (-7.0, -10.0)
    assert found.shape == (420, 380)
    navigator.update(reading)
    assert is_occupied(navigator, (2.0, -2.0))
    assert path_of(navigator)[-1] == pytest.approx((4.0, 3.0))


def test_a_new_plan_is_made_once_a_second() -> None:
    reading = make_reading(START, GOAL)
    navigator = Navigator(FakeRobot(free_map(), reading), NavigatorOptions(), reading)
    paths = []
    for _ in range(11):
        navigator.update(reading)
        paths.append(path_of(navigator))
    is_new = [True, *(one is not other for one, other in zip(paths[1:], paths[:-1], strict=True))]
    assert [index for index, each in enumerate(is_new) if each] == [0, 5, 10]  # of 0.2 s


def test_a_goal_that_moves_makes_a_new_plan_at_once() -> None:
    reading = make_reading(START, GOAL)
    navigator = Navigator(FakeRobot(free_map(), reading), NavigatorOptions(), reading)
    navigator.update(reading)
    navigator.update(make_reading(START, (3.55, 0.55)))
    assert path_of(navigator)[-1] == pytest.approx((3.55, 0.55))
    before = path_of(navigator)
    navigator.update(make_reading(START, (3.55, 0.55)))
    assert path_of(navigator) is before


def test_an_obstacle_on_the_path_makes_a_new_plan_at_once_and_one_behind_does_not() -> None:
    robot = FakeRobot(free_map(), make_reading((0.55, 2.05, math.pi / 2), GOAL))  # the first scan sees no path
    navigator = Navigator(robot, NavigatorOptions(), robot.reading)
    navigator.update(robot.reading)
    straight = path_of(navigator)
    assert straight[:, 1] == pytest.approx(2.05)
    navigator.update(make_reading((1.55, 2.05, math.pi), GOAL, [0.5]))  # it looks back: (1.05, 2.05)
    assert is_occupied(navigator, (1.05, 2.05))
    assert path_of(navigator) is straight
    navigator.update(make_reading((1.55, 2.05, 0.0), GOAL, [1.0]))  # (2.55, 2.05)
    assert path_of(navigator) is not straight
    assert np.hypot(*(path_of(navigator) - (2.55, 2.05)).T).min() > 0.15


def test_a_goal_out_of_reach_leaves_no_path() -> None:
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    for goal in (GOAL, (40.0, 2.0), (3.0, -9.0)):
        reading = make_reading(START, goal)
        navigator = Navigator(FakeRobot(grid, reading), NavigatorOptions(), reading)
        navigator.update(reading)
        assert navigator.path is None


# MoveBase -------------------------------------------------------------------------------------------------------------


def commands(driver: MoveBase, count: int) -> list[tuple[float, float]]:
    decided = [driver.decide(OBSERVATION) for _ in range(count)]
    assert {each.driver for each in decided} == {Driver.PLANNER}
    return [(round(float(v), 6), round(float(omega), 6)) for v, omega in (each.action for each in decided)]


def test_move_base_drives_to_its_goal_through_the_gap() -> None:
    robot = FakeRobot(map_with_gap(), make_reading((0.55, 0.55, 0.0), (3.55, 0.55)))
    driver = MoveBase(robot, NavigatorOptions(uses_scans=False))
    driver.begin_episode()
    position = np.array([0.55, 0.55, 0.0])
    v = omega = 0.0
    for _ in range(200):
        x, y, yaw = position.tolist()
        if math.hypot(x - 3.55, y - 0.55) < 0.3:
            break
        robot.reading = make_reading((x, y, yaw), (3.55, 0.55), velocity=(v, omega))
        action = driver.decide(OBSERVATION).action
        assert action.dtype == np.float32
        v, omega = (float(each) for each in action)
        middle = yaw + 0.1 * omega
        position += 0.2 * np.array([v * math.cos(middle), v * math.sin(middle), omega])
        turn = np.array(
            [(math.cos(position[2]), math.sin(position[2])), (-math.sin(position[2]), math.cos(position[2]))]
        )
        corners = FOOTPRINT @ turn + position[:2]
        is_in_wall = (corners[:, 0] > 2.0) & (corners[:, 0] < 2.1) & ((corners[:, 1] < 3.0) | (corners[:, 1] > 3.8))
        assert not is_in_wall.any()
    else:
        pytest.fail("it did not arrive")


def test_move_base_clears_and_then_turns_where_dwa_finds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    cleared: list[int] = []
    found: list[tuple[float, float]] = []
    monkeypatch.setattr(Navigator, "clear", lambda _: cleared.append(len(found)))
    robot = FakeRobot(free_map(), make_reading((2.05, 2.05, 0.0), GOAL))
    driver = MoveBase(robot, dwa=NO_WAY)
    for _ in range(60):
        found += commands(driver, 1)
    # A second without a command clears, the next begins a turn of 2π rad at 1 rad/s: 31.4 steps of 0.2 s. Then again.
    assert found == [(0.0, 0.0)] * 10 + [(0.0, 1.0)] * 32 + [(0.0, 0.0)] * 10 + [(0.0, 1.0)] * 8
    assert cleared == [4, 46]


def test_a_recovery_forgets_the_obstacles_that_only_the_laser_saw() -> None:
    robot = FakeRobot(free_map(), make_reading((2.05, 2.05, 0.0), GOAL, [0.7]))
    driver = MoveBase(robot, dwa=NO_WAY)
    commands(driver, 1)
    assert driver.navigator is not None
    assert is_occupied(driver.navigator, (2.75, 2.05))
    robot.reading = make_reading((2.05, 2.05, 2.0), GOAL, [np.inf])  # it looks elsewhere
    commands(driver, 3)
    assert is_occupied(driver.navigator, (2.75, 2.05))
    commands(driver, 1)
    assert not is_occupied(driver.navigator, (2.75, 2.05))


def test_a_goal_without_a_path_makes_move_base_recover_too() -> None:
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    driver = MoveBase(FakeRobot(grid, make_reading((1.05, 2.05, 0.0), GOAL)))
    assert commands(driver, 12) == [(0.0, 0.0)] * 10 + [(0.0, 1.0)] * 2


def test_a_command_of_dwa_ends_the_wait_for_a_recovery() -> None:
    robot = FakeRobot(free_map(), make_reading((1.05, 2.05, 0.0), (40.0, 40.0)))
    driver = MoveBase(robot)
    commands(driver, 4)
    robot.reading = make_reading((1.05, 2.05, 0.0), GOAL)
    assert commands(driver, 1)[0][0] > 0.0
    robot.reading = make_reading((1.05, 2.05, 0.0), (40.0, 40.0))
    assert commands(driver, 9) == [(0.0, 0.0)] * 9  # without it the turn would have begun after 6


def test_a_recovery_turn_ends_where_the_robot_would_touch_something() -> None:
    grid = free_map()
    grid.cells[:, 22] = OCCUPIED  # x from 2.2 m on: in front of a corner that turns
    driver = MoveBase(FakeRobot(grid, make_reading((1.99, 2.05, 0.0), (0.55, 2.05))), dwa=NO_WAY)
    assert commands(driver, 20) == [(0.0, 0.0)] * 20


def test_a_recovery_turn_is_cut_at_the_robots_limits() -> None:
    shape = make_shape(low=(0.0, -0.7), high=(0.5, 0.7))
    driver = MoveBase(FakeRobot(free_map(), make_reading((2.05, 2.05, 0.0), GOAL), shape), dwa=NO_WAY)
    assert commands(driver, 11)[-1] == (0.0, 0.7)


def test_a_new_episode_forgets_map_plan_and_recovery() -> None:
    robot = FakeRobot(free_map(), make_reading((2.05, 2.05, 0.0), GOAL, [0.7]))
    driver = MoveBase(robot, dwa=NO_WAY)
    assert commands(driver, 11)[-1] == (0.0, 1.0)
    driver.begin_episode()
    robot.reading = make_reading((2.05, 2.05, 0.0), GOAL)
    assert commands(driver, 10) == [(0.0, 0.0)] * 10
    assert driver.navigator is not None
    assert not is_occupied(driver.navigator, (2.75, 2.05))


def test_a_planner_learns_nothing() -> None:
    step = Step(
        OBSERVATION, Decision(np.zeros(2, dtype=np.float32), Driver.PLANNER), 0.0, OBSERVATION, False, False, {}
    )
    robot = FakeRobot(free_map(), make_reading(START, GOAL))
    assert MoveBase(robot).learn(step) == {}
    assert WaypointDriver(robot, Listener()).learn(step) == {}


# WaypointDriver -------------------------------------------------------------------------------------------------------


class Listener:
    """A local driver that keeps what it is given."""

    def __init__(self) -> None:
        self.observations: list[Observation] = []
        self.episodes = 0
        self.decision = Decision(np.array([0.3, -0.2], dtype=np.float32), Driver.POLICY)

    def begin_episode(self) -> None:
        self.episodes += 1

    def decide(self, observation: Observation) -> Decision:
        self.observations.append(observation)
        return self.decision

    def learn(self, step: Step) -> Mapping[str, float]:
        raise AssertionError("it is only driven")


def given(robot: FakeRobot, look_ahead: float = 1.0) -> Observation:
    """What the local driver is given in the first step."""
    local = Listener()
    driver = WaypointDriver(robot, local, look_ahead, NavigatorOptions(uses_scans=False))
    driver.begin_episode()
    assert driver.decide(OBSERVATION) is local.decision
    (observation,) = local.observations
    return observation


def test_the_waypoint_is_given_in_the_robots_frame_and_nothing_else_changes() -> None:
    # Facing along y at (1.05, 1.05), the path leads straight along x: the waypoint (2.05, 1.05) is 1 m to the right.
    before = OBSERVATION.copy()
    observation = given(FakeRobot(free_map(), make_reading((1.05, 1.05, math.pi / 2), (3.05, 1.05))))
    np.testing.assert_allclose(observation[-2:], (0.0, -1.0), atol=1e-6)
    assert observation[:-2].tolist() == before[:-2].tolist()
    assert observation.dtype == np.float32
    assert OBSERVATION.tolist() == before.tolist()


def test_the_look_ahead_goes_along_the_path_and_ends_at_the_goal() -> None:
    robot = FakeRobot(free_map(), make_reading((1.05, 1.05, 0.0), (2.55, 1.05)))
    np.testing.assert_allclose(given(robot, 0.6)[-2:], (0.6, 0.0), atol=1e-6)
    np.testing.assert_allclose(given(robot, 5.0)[-2:], (1.5, 0.0), atol=1e-6)


def test_the_waypoint_leads_around_a_wall() -> None:
    # The goal is straight behind the wall, the gap in it to the robot's left.
    x, y = given(FakeRobot(map_with_gap(), make_reading((1.05, 0.55, 0.0), (3.05, 0.55))))[-2:].tolist()
    assert y > 0.8
    assert abs(x) < 0.6


def test_without_a_path_the_local_driver_is_given_the_goal_itself() -> None:
    # From (1.05, 2.05), turned by 30°, the goal is 2.5 m along x: 2.5 (cos 30°, −sin 30°) in the robot's frame.
    grid = free_map()
    grid.cells[:, 20] = OCCUPIED
    observation = given(FakeRobot(grid, make_reading((1.05, 2.05, math.pi / 6), (3.55, 2.05))))
    np.testing.assert_allclose(observation[-2:], (2.165064, -1.25), atol=1e-6)


def test_another_goal_by_hand() -> None:
    # From (1, 2), turned by atan(3/4), to (3, 1): 0.8 · 2 + 0.6 · (−1) = 1 ahead, 0.8 · (−1) − 0.6 · 2 = −2 to the left
    reading: Reading = make_reading((1.0, 2.0, math.atan2(3.0, 4.0)))
    np.testing.assert_allclose(with_goal(OBSERVATION, reading, (3.0, 1.0))[-2:], (1.0, -2.0), atol=1e-6)


def test_the_local_driver_begins_its_episodes_with_the_leading_one() -> None:
    local = Listener()
    robot = FakeRobot(free_map(), make_reading(START, GOAL, [1.0]))
    driver = WaypointDriver(robot, local)
    driver.begin_episode()
    driver.decide(OBSERVATION)
    first = driver.navigator
    assert first is not None
    driver.decide(OBSERVATION)
    assert driver.navigator is first
    driver.begin_episode()
    driver.decide(OBSERVATION)
    assert local.episodes == 2
    assert driver.navigator is not first
    assert (free_map().cells == FREE).all()
