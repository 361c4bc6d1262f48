"""Driving by keyboard without a screen."""

import math
from pathlib import Path

import pytest

from asddpg.errors import UserError
from tasks.constants import MAX_ANGULAR_VELOCITY, MAX_LINEAR_VELOCITY
from tasks.physics import Velocity
from tasks.registry import make_rule
from tasks.scene.loading import open_scene, robot_physics
from tools import teleop
from tools.robot import viewer
from tools.robot.scene_argument import PIONEER_SCENE, scene_model
from tools.robot.teleop_keys import (
    ANGULAR_PRESSES,
    BACKSPACE,
    DOWN,
    LEFT,
    LINEAR_PRESSES,
    RIGHT,
    SPACE,
    UP,
    next_command,
)
from tools.teleop import TeleopSession

LINEAR_STEP, ANGULAR_STEP = MAX_LINEAR_VELOCITY / LINEAR_PRESSES, MAX_ANGULAR_VELOCITY / ANGULAR_PRESSES


def start_session(task: str) -> TeleopSession:
    physics = robot_physics(scene_model(task), task)
    return TeleopSession(physics, make_rule(task, physics.model.ptr))


def test_each_arrow_adds_its_step_and_space_stops() -> None:
    command = Velocity(0.0, 0.0)
    for key, expected in (
        (UP, (LINEAR_STEP, 0.0)),
        (LEFT, (LINEAR_STEP, ANGULAR_STEP)),
        (DOWN, (0.0, ANGULAR_STEP)),
        (RIGHT, (0.0, 0.0)),
        (RIGHT, (0.0, -ANGULAR_STEP)),
        (ord("W"), (0.0, -ANGULAR_STEP)),
        (SPACE, (0.0, 0.0)),
    ):
        command = next_command(command, key)
        assert tuple(command) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("key", "back", "limit"),
    [
        (UP, DOWN, (MAX_LINEAR_VELOCITY, 0.0)),
        (DOWN, UP, (-MAX_LINEAR_VELOCITY, 0.0)),
        (LEFT, RIGHT, (0.0, MAX_ANGULAR_VELOCITY)),
        (RIGHT, LEFT, (0.0, -MAX_ANGULAR_VELOCITY)),
    ],
)
def test_commands_stay_within_the_limits_and_come_back_to_rest(key: int, back: int, limit: tuple[float, float]) -> None:
    command, presses = Velocity(0.0, 0.0), 0
    for _ in range(20):
        command = next_command(command, key)
    assert tuple(command) == pytest.approx(limit)
    assert abs(command.linear) <= MAX_LINEAR_VELOCITY
    assert abs(command.angular) <= MAX_ANGULAR_VELOCITY
    while command != (0.0, 0.0):
        command = next_command(command, back)
        presses += 1
    assert presses in (5, 6)


def test_another_robot_is_driven_within_its_own_limits(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    driven: list[TeleopSession] = []
    monkeypatch.setattr(teleop, "check_screen", lambda: None)
    monkeypatch.setattr(teleop, "drive", driven.append)
    teleop.main(["nav_simple", "robot=turtlebot3_burger"])
    assert "0.044 m/s a press" in capsys.readouterr().out
    (session,) = driven
    for _ in range(7):
        session.press(UP)
    session.advance(50)
    assert session.status()["v"] == "+0.22 m/s, command +0.22"


def test_keys_drive_the_robot_into_a_crash_and_backspace_resets_it() -> None:
    driven = start_session("nav_complex")
    goal = driven.physics.goal()
    assert driven.frame <= 0.2
    for _ in range(5):
        driven.press(UP)
    for _ in range(round(1.4 / driven.frame)):
        driven.advance()
    status = driven.status()
    assert 0.4 < driven.physics.pose().x < 0.75
    assert status["v"].endswith("command +0.50")
    assert status["crashed"] == "no"
    for _ in range(round(6.0 / driven.frame)):
        driven.advance()
    assert driven.status()["crashed"] == "yes"
    driven.press(BACKSPACE)
    assert driven.physics.pose().x == 0.0
    assert driven.command == (0.0, 0.0)
    assert driven.physics.goal() != goal


def test_the_robots_own_scene_begins_in_its_keyframe() -> None:
    driven = TeleopSession(open_scene(PIONEER_SCENE))
    assert driven.status()["to the goal"] == "2.00 m"


def test_no_screen_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer, "_opens_window", lambda _: False)
    with pytest.raises(UserError, match="needs a screen.*xvfb-run") as caught:
        teleop.main(["nav_empty"])
    assert "\n" not in str(caught.value)


def test_a_scene_without_the_robot_gets_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    driven: list[TeleopSession] = []
    monkeypatch.setattr(teleop, "check_screen", lambda: None)
    monkeypatch.setattr(teleop, "drive", driven.append)
    path = tmp_path / "ball.xml"
    path.write_text("<mujoco><worldbody><geom size='1' name='ball'/></worldbody></mujoco>")
    teleop.main([str(path)])
    assert f"{path} has no robot: the Pioneer is put into it" in capsys.readouterr().out
    (session,) = driven
    assert session.physics.model.geom("ball").id >= 0
    x, y, _ = session.physics.pose()
    assert math.hypot(x, y) > 1.0
    session.press(UP)
    session.advance(10)
    assert session.status()["crashed"] == "no"


def test_the_clock_catches_up_and_skips_long_delays(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [10.0]

    def sleep(seconds: float) -> None:
        now[0] += seconds

    monkeypatch.setattr("tools.robot.viewer.time.monotonic", lambda: now[0])
    monkeypatch.setattr("tools.robot.viewer.time.sleep", sleep)
    frames, done = viewer.wait_for_frames(0.02), 0
    for drawing in (0.001, 0.015, 0.1, 0.03, 0.001, 0.2):
        done += next(frames)
        now[0] += drawing
    assert done == pytest.approx((now[0] - 0.2 - 10.0) / 0.02, abs=1.1)
    now[0] += 60.0
    assert next(frames) == viewer.LATE / 0.02
    assert next(frames) == 1
