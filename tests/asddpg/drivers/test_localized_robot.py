"""A robot that localises itself, and the tool that takes its errors."""

from pathlib import Path

import numpy as np
import pytest

from asddpg.build import make_environment, navigation_env
from asddpg.command_line import train_config
from asddpg.drivers.localized_robot import LocalizationOptions, LocalizedRobot
from asddpg.drivers.room_map import draw_room_map
from asddpg.errors import UserError
from asddpg.planning.odometry import OdometryErrors
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.room_geometry.obstacles import Obstacles
from tools import localization

STEPS = 25


def make_room() -> NavigationEnv:
    config = train_config(["task=nav_complex", "task.min_linear_velocity=0"])
    return navigation_env(make_environment(config.task, config.reward))


def make_robot(environment: NavigationEnv, factor: float = 1.0) -> LocalizedRobot:
    options = LocalizationOptions(OdometryErrors(factor, factor))
    return LocalizedRobot(environment, draw_room_map(environment.obstacles), np.random.default_rng(0), options)


def test_its_pose_and_speeds_are_near_the_true_ones_and_the_goal_is_the_environments() -> None:
    environment = make_room()
    robot = make_robot(environment, factor=1.05)
    observation, info = environment.reset(options={"goal": (3.5, -3.5)})
    robot.begin(observation, info["pose"])
    for _ in range(STEPS):
        observation, _, terminated, _, info = environment.step(np.array([0.2, -0.3]))
        assert not terminated
        reading = robot.read(observation)
    x, y, yaw = np.subtract(reading.pose, info["pose"])
    assert np.hypot(x, y) < 0.15
    assert abs(yaw) < 0.15
    assert reading.pose != info["pose"], "an estimate"
    assert reading.velocity == pytest.approx((0.2 * 1.05, -0.3 * 1.05), abs=0.03), "of the wheels, taken for too large"
    assert reading.goal == info["goal"]


def test_an_observation_is_taken_once() -> None:
    environment = make_room()
    robot = make_robot(environment)
    observation, info = environment.reset(seed=0)
    first = robot.begin(observation, info["pose"])
    particles = robot.amcl.particles.copy()
    assert robot.read(observation) is first
    assert np.array_equal(robot.amcl.particles, particles)


def test_a_moved_goal_is_read_at_once_and_nothing_else_changes() -> None:
    environment = make_room()
    robot = make_robot(environment)
    observation, info = environment.reset(options={"goal": (3.5, -3.5)})
    first = robot.begin(observation, info["pose"])
    particles = robot.amcl.particles.copy()
    moved = robot.read(environment.set_goal(-3.0, 3.0))
    assert moved.goal == (-3.0, 3.0)
    assert moved._replace(goal=first.goal)[:3] == first[:3]
    assert moved.ranges is first.ranges
    assert robot.reading is moved
    assert np.array_equal(robot.amcl.particles, particles)
    observation, *_ = environment.step(np.array([0.2, 0.0]))
    assert robot.read(observation).goal == (-3.0, 3.0)


def test_wheel_angles_are_those_of_the_distance_driven() -> None:
    environment = make_room()
    environment.reset(options={"goal": (3.5, -3.5), "start": (0.0, -0.6, 0.0)})
    before = environment.physics.wheel_angles()
    for _ in range(10):
        _, _, _, _, info = environment.step(np.array([0.2, 0.0]))
    turned = np.subtract(environment.physics.wheel_angles(), before)
    assert turned * 0.0975 == pytest.approx(np.full(2, info["pose"][0]), abs=0.005)  # wheels of 0.0975 m


def test_obstacles_can_be_left_out_by_name() -> None:
    model = navigation_env(
        make_environment(*(getattr(train_config(["task=nav_office"]), name) for name in ("task", "reward")))
    ).physics.model.ptr
    every, fewer = Obstacles.from_model(model), Obstacles.from_model(model, ["sofa", "desk_1"])
    assert len(every.outlines) - len(fewer.outlines) == 1 + 4, "a box, and four legs"
    with pytest.raises(TaskError, match="there is|no obstacle 'sofas'; it has .*sofa"):
        Obstacles.from_model(model, ["sofas"])


@pytest.mark.slow
def test_the_tool_prints_errors_and_writes_a_row_a_drive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "errors.csv"
    options = ["task=nav_complex", "unmapped=[]", "drives=2", "seconds=4", f"out={out}"]
    localization.main(options)
    printed = capsys.readouterr().out
    assert "lost in 0 of 2 drives" in printed
    assert [row.split(",")[:2] for row in out.read_text().splitlines()] == [["seed", "steps"], ["0", "20"], ["1", "20"]]
    localization.main([*options, "start=anywhere"])
    assert "of 2 (bar: 16 of 20)" in capsys.readouterr().out


def test_the_tools_mistakes_are_one_sentence() -> None:
    with pytest.raises((UserError, TaskError), match="no obstacle 'nothing'"):
        localization.main(["task=nav_complex", "unmapped=[nothing]", "drives=1", "seconds=1"])
