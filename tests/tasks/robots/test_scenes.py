"""A robot of a user's in the tasks: its scenes, its limits, its starts and its shape."""

from pathlib import Path

import gymnasium
import mujoco
import numpy as np
import pytest
from numpy.testing import assert_array_equal

import tasks
from tasks.constants import GOAL_RADIUS
from tasks.errors import TaskError
from tasks.evaluation_pairs import stored_pairs
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tasks.navigation import NavigationConfig, with_robot
from tasks.registry import task_model
from tasks.room_geometry.footprints import Footprint
from tasks.scene.frames import BodyFrames
from tasks.scene.loading import TASK_CAMERAS, scene_path
from tasks.scene.shapes import scene_parts
from tests.support.robots import write_robot

BURGER = "turtlebot3_burger"


@pytest.mark.parametrize("task", [*tasks.ALL_TASKS, "cylinders:3"])
def test_it_drives_in_every_room(task: str) -> None:
    environment = tasks.load(task, random=0, config={"robot": BURGER})
    environment.reset()
    for _ in range(5):
        environment.step(np.array([0.22, 0.0]))
    assert environment.physics.readings().velocity.linear == pytest.approx(0.22, rel=0.02)
    model = environment.physics.model.ptr
    assert {model.cam(index).name for index in range(model.ncam)} >= {*TASK_CAMERAS}


def test_the_pioneers_scene_is_as_ever() -> None:
    """The model of a scene identifies its runs."""
    plain = mujoco.MjModel.from_xml_path(str(scene_path("nav_simple")))
    loaded = task_model("nav_simple", robot="pioneer")
    assert mujoco.mj_sizeModel(plain) == mujoco.mj_sizeModel(loaded)
    assert_array_equal(plain.geom_pos, loaded.geom_pos)


def test_nothing_of_the_pioneer_stays() -> None:
    model, own = task_model("nav_simple", robot=BURGER), task_model("nav_simple")
    assert {model.geom(geom).name for geom in range(model.ngeom)}.isdisjoint({"hull", "deck_plate", "left_wheel"})
    assert (model.nmesh, model.nu) == (0, 2)
    assert Footprint.from_model(model).radius < Footprint.from_model(own).radius / 2


def test_its_own_shape_is_shown() -> None:
    model = task_model("nav_simple", robot=BURGER)
    owners = [part.owner for part in scene_parts(model)]
    assert owners.count("robot_left_wheel") == 2  # tyre and rim
    frames = {frame.name: frame.parent for frame in BodyFrames.from_model(model).frames}
    assert frames["base"] == "world"
    assert frames["laser"] == "base"  # of the scans


def test_the_tasks_limits_follow_the_robots() -> None:
    pioneer, burger = NavigationConfig(), NavigationConfig(robot=BURGER)
    assert (pioneer.max_linear_velocity, pioneer.max_angular_velocity) == (0.5, np.pi / 3)
    assert (burger.max_linear_velocity, burger.max_angular_velocity) == (0.22, 2.84)
    assert NavigationConfig(robot=BURGER, max_linear_velocity=0.1).max_linear_velocity == 0.1
    with pytest.raises(
        TaskError, match=r"max_linear_velocity must be above 0 and up to the robot's 0\.22 m/s, not 0\.3"
    ):
        NavigationConfig(robot=BURGER, max_linear_velocity=0.3)
    changed = with_robot(pioneer, BURGER)
    assert (changed.max_linear_velocity, changed.max_angular_velocity) == (0.22, np.pi / 3)


def test_a_robot_is_kept_by_a_path_that_holds_everywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_robot(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert NavigationConfig(robot="robot.xml").robot == path
    wheels = "@wheel_left_joint,wheel_right_joint"
    assert NavigationConfig(robot=f"robot.xml{wheels}").robot == path + wheels


def test_many_robots_drive_as_one_does(tmp_path: Path) -> None:
    config = {"robot": write_robot(tmp_path)}
    robots = NavigationVectorEnv("nav_simple", 2, config=config)
    with gymnasium.make("tasks:asddpg/NavSimple-v0", config=config) as alone:
        together, _ = robots.reset(seed=[3, 4])
        observation, _ = alone.reset(seed=3)
        assert_array_equal(together[0], observation)
        for _ in range(5):
            together, *_ = robots.step(np.array([[0.4, 0.7], [0.3, -0.5]]))
            observation, *_ = alone.step(np.array([0.4, 0.7]))
            assert_array_equal(together[0], observation)
    robots.close()


def test_the_stored_pairs_have_the_robots_own_paths() -> None:
    pioneer = stored_pairs("nav_simple", "test", GOAL_RADIUS, 20)
    burger = stored_pairs("nav_simple", "test", GOAL_RADIUS, 20, BURGER)
    assert [pair.goal for pair in burger] == [pair.goal for pair in pioneer]
    assert all(own.shortest_path <= other.shortest_path + 0.05 for own, other in zip(burger, pioneer, strict=True))
    assert any(own.shortest_path < other.shortest_path - 0.01 for own, other in zip(burger, pioneer, strict=True))


def test_a_larger_robot_has_the_pairs_that_it_can_start_in(tmp_path: Path) -> None:
    wide = '<body name="bumper_ring"><geom type="cylinder" size="0.5 0.01" pos="0 0 0.1" mass="0.1"/></body>'
    pairs = stored_pairs("nav_gazebo", "validation", GOAL_RADIUS, robot=write_robot(tmp_path, laser=wide))
    assert 0 < len(pairs) < 50
    huge = write_robot(tmp_path, "huge.xml", laser=wide.replace('size="0.5', 'size="3'))
    with pytest.raises(TaskError, match="is too large for nav_gazebo: it fits at none of the stored starts"):
        stored_pairs("nav_gazebo", "validation", GOAL_RADIUS, robot=huge)
    model = task_model("nav_gazebo", robot=write_robot(tmp_path, laser=wide))
    assert Footprint.from_model(model).radius == pytest.approx(0.5, abs=0.01)
