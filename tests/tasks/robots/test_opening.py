"""Robots of a user's: what is read of their files, what they drive, and the sentences of those that do not."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tasks import constants
from tasks.errors import TaskError
from tasks.robots.names import PIONEER, SHIPPED
from tasks.robots.opening import load_robot, measure_speeds, open_robot
from tests.support.robots import LASER, write_robot


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_robot_drives_what_it_is_commanded(name: str) -> None:
    commanded, driven = measure_speeds(load_robot(name), name)
    assert_allclose(driven, commanded, rtol=0.003)


def test_the_burger_has_its_published_figures() -> None:
    physics = load_robot("turtlebot3_burger")
    assert physics.drive.radius == pytest.approx(0.033)
    assert physics.drive.track == pytest.approx(0.160)
    assert physics.drive.task_limits == (0.22, 2.84)
    assert physics.model.body_subtreemass[physics.model.name2id("base", "body")] == pytest.approx(1.0, abs=0.01)


def test_the_pioneer_is_opened_without_a_drive() -> None:
    robot, task = open_robot(PIONEER)
    assert robot == (constants.WHEEL_SPEED_LIMIT * constants.WHEEL_RADIUS, constants.TURN_RATE_LIMIT)
    assert task == (constants.MAX_LINEAR_VELOCITY, constants.MAX_ANGULAR_VELOCITY)


def test_a_robot_of_other_names_axes_place_and_heading_drives(tmp_path: Path) -> None:
    name = write_robot(tmp_path)
    physics = load_robot(name)
    assert physics.drive.radius == pytest.approx(0.05)
    assert physics.drive.track == pytest.approx(0.2)
    assert [wheel.gain for wheel in physics.drive.wheels] == [3.0, -1.0]
    assert open_robot(name).robot[0] == pytest.approx(1.0)  # 20 rad/s
    commanded, driven = measure_speeds(physics, name)
    assert_allclose(driven, commanded, rtol=0.02)
    left, right = physics.wheel_angles()
    assert left < 0.0 < right  # on the spot to the left


def test_a_robot_states_its_limits(tmp_path: Path) -> None:
    stated = '<custom><numeric name="max_linear_velocity" data="0.3"/></custom>'
    robot, task = open_robot(write_robot(tmp_path, more=stated))
    assert (robot[0], task[0]) == (0.3, 0.3)
    assert task[1] == constants.MAX_ANGULAR_VELOCITY


def test_the_pioneers_own_file_is_a_robot_like_any_other(tmp_path: Path) -> None:
    """It drives the same commands into the same places, but for rounding."""
    path = shutil.copy(SHIPPED[PIONEER], tmp_path)
    own, copied = load_robot(PIONEER), load_robot(str(path))
    for physics in (own, copied):
        physics.set_velocity_command(0.4, 0.5)
        physics.step(400)
    assert_allclose(copied.pose(), own.pose(), atol=1e-3)
    assert copied.num_beams == own.num_beams == constants.NUM_BEAMS
    assert copied.sonar_ranges().shape == own.sonar_ranges().shape
    assert_allclose(copied.sensor("bumper"), 0.0)


# Laser ----------------------------------------------------------------------------------------------------------------


def laser_place(name: str) -> np.ndarray:
    physics = load_robot(name)
    with physics.reset_context():
        pass
    assert physics.num_beams == constants.NUM_BEAMS
    assert physics.ranges().min() == constants.MAX_RANGE  # it does not see itself
    return np.array(physics.named.data.site_xpos["ray_00"])


def test_the_laser_is_where_the_robot_has_its_own(tmp_path: Path) -> None:
    assert_allclose(laser_place(write_robot(tmp_path)), [0.05, 0.0, 0.17], atol=1e-3)


def test_a_robot_without_a_laser_has_it_above_its_highest_part(tmp_path: Path) -> None:
    assert_allclose(laser_place(write_robot(tmp_path, laser="")), [0.0, 0.0, 0.15], atol=1e-3)


def test_a_turned_laser_is_refused(tmp_path: Path) -> None:
    turned = LASER.replace("<body ", '<body euler="0 0 3.14159" ')
    with pytest.raises(TaskError, match="has a laser on the turned body 'base_scan'; x must lead ahead"):
        open_robot(write_robot(tmp_path, laser=turned))


# Errors ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"servo": "motor", "gain": ""}, "drives its wheel 'wheel_right_joint' by an actuator that keeps no speed"),
        (
            {"caster": "", "wheel": "cylinder", "width": "0.01"},
            r"does not obey: 1\.05 rad/s on the spot is commanded and 0\.[0-9]+ rad/s is driven",
        ),
        ({"kv": "0.00001"}, r"does not obey: 0\.5 m/s straight on is commanded and -?0\.[0-9]+ m/s is driven"),
        ({"more": "<nosuch/>"}, "cannot be compiled: .*nosuch"),
        ({"width": "nan 0.01"}, "geom"),
    ],
)
def test_a_robot_that_cannot_drive_says_why_in_one_sentence(
    changes: dict[str, str], sentence: str, tmp_path: Path
) -> None:
    name = write_robot(tmp_path, **changes)
    with pytest.raises(TaskError, match=sentence) as raised:
        open_robot(name)
    assert "\n" not in str(raised.value)
    assert name in str(raised.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>", "no two wheels, .* it drives no hinge joint"),
        ("<mujoco><worldbody>", "cannot be compiled: XML"),
        ("", "cannot be compiled"),
        (
            "<mujoco><worldbody><body><joint name='a'/><geom size='1'/></body><body><joint name='b'/><geom size='1'/>"
            "</body></worldbody><actuator><velocity joint='a'/><velocity joint='b'/></actuator></mujoco>",
            "does not say which of its joints a, b are its two wheels",
        ),
        (
            "<mujoco><worldbody><body><joint name='left'/><geom size='1'/></body><body><joint name='right'/>"
            "<geom size='1'/></body></worldbody><actuator><velocity joint='left'/><velocity joint='right'/></actuator>"
            "</mujoco>",
            "has wheels that hang on no common body",
        ),
    ],
)
def test_a_file_that_holds_no_robot_says_why_in_one_sentence(text: str, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "file.xml").write_text(text)
    with pytest.raises(TaskError, match=sentence) as raised:
        open_robot(str(tmp_path / "file.xml"))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("name", ["nosuch", "", "nosuch.yaml", "\0", "a" * 5000])
def test_an_unknown_robot_names_those_there_are(name: str) -> None:
    with pytest.raises(
        TaskError, match="there is no robot '.*'; there are pioneer, turtlebot3_burger, or an MJCF file"
    ):
        open_robot(name)


@pytest.mark.parametrize("name", ["nosuch.xml", "nosuch.xml@a,b", "\0.xml", f"{'a' * 5000}.xml"])
def test_a_missing_file_is_named(name: str) -> None:
    with pytest.raises(TaskError, match="there is no robot file .*; an MJCF file, .xml, is expected"):
        open_robot(name)


def test_wheels_are_named_behind_the_file(tmp_path: Path) -> None:
    name = write_robot(tmp_path)
    Path(name).write_text(Path(name).read_text().replace("wheel_left", "a").replace("wheel_right", "b"))
    with pytest.raises(TaskError, match="<file>@<left joint>,<right joint> does"):
        open_robot(name)
    for wheels in ("a_joint,b_joint", "a_joint,right_motor"):
        assert open_robot(f"{name}@{wheels}").robot[0] == pytest.approx(1.0)
    with pytest.raises(TaskError, match="has a laser on the turned body"):  # what was ahead is behind
        open_robot(f"{name}@b_joint,a_joint")
    with pytest.raises(TaskError, match="has no wheel 'c'; it drives the joints a_joint, b_joint"):
        open_robot(f"{name}@a_joint,c")
    with pytest.raises(TaskError, match="stand the joints of its two wheels"):
        open_robot(f"{name}@a_joint")
