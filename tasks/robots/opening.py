"""Opens robots: each is driven for a few seconds on an empty floor, once in a process, before it is let into a task."""

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import mujoco
import numpy as np
from dm_control.rl.control import PhysicsError

from tasks.constants import (
    MAX_ANGULAR_VELOCITY,
    MAX_LINEAR_VELOCITY,
    TURN_RATE_LIMIT,
    WHEEL_RADIUS,
    WHEEL_SPEED_LIMIT,
)
from tasks.errors import TaskError
from tasks.physics import Physics, Pose
from tasks.robots.names import PIONEER, find_robot
from tasks.robots.replacement import replace_robot
from tasks.scene.loading import MODELS, load_model, robot_physics

FLOOR = MODELS / "own_room.xml"  # the Pioneer on an empty floor
GOAL = (2.0, 0.0, 0.0)  # m, out of the picture
DRIVE_TIME, SETTLING_TIME = 2.0, 1.0  # s of each command, of them before the speed is taken
TOLERANCE = 0.1  # share of a command by which a robot may fall short of it, or exceed it
_SAMPLE = 0.05  # s


class SpeedLimits(NamedTuple):
    """Speeds of a robot, m/s and rad/s.

    Attributes:
        robot: the largest v and ω that it takes.
        task: the largest of a task that gives none of its own.
    """

    robot: tuple[float, float]
    task: tuple[float, float]


class DrivenSpeeds(NamedTuple):
    """What was commanded and what was driven: straight on, m/s, and on the spot, rad/s."""

    commanded: tuple[float, float]
    driven: tuple[float, float]


_PIONEER = SpeedLimits((WHEEL_SPEED_LIMIT * WHEEL_RADIUS, TURN_RATE_LIMIT), (MAX_LINEAR_VELOCITY, MAX_ANGULAR_VELOCITY))


def open_robot(name: str) -> SpeedLimits:
    """The limits of a robot that obeys its commands; the Pioneer is known to.

    Raises:
        TaskError: there is no such robot, its file holds none, or it does not drive as it is commanded.
    """
    if name == PIONEER:
        return _PIONEER
    status = find_robot(name).path.stat()
    return _open(name, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=16)
def _open(name: str, _changed: int, _size: int) -> SpeedLimits:
    """Open a file once, until it changes."""
    physics = load_robot(name)
    drive, speeds = physics.drive, measure_speeds(physics, name)
    for kind, unit, command, driven in zip(
        ("straight on", "on the spot"), ("m/s", "rad/s"), speeds.commanded, speeds.driven, strict=True
    ):
        if not abs(driven - command) <= TOLERANCE * command:
            raise TaskError(
                f"the robot {name} does not obey: {command:.3g} {unit} {kind} is commanded and {driven:.3g} {unit} is "
                f"driven; its wheels, of {drive.radius:.3g} m radius and {drive.track:.3g} m apart, need "
                "velocity actuators that are strong enough, and its casters no friction"
            )
    return SpeedLimits((drive.max_linear_velocity, drive.max_angular_velocity), drive.task_limits)


def load_robot(name: str) -> Physics:
    """A robot on an empty floor; TaskError where no robot has that name or its file has no robot."""

    def prepare(spec: mujoco.MjSpec) -> None:
        replace_robot(spec, name)
        spec.body("goal").pos = GOAL

    return robot_physics(load_model(FLOOR, prepare=prepare), name)


def measure_speeds(physics: Physics, name: str) -> DrivenSpeeds:
    """Drive at the task's limits from rest, straight on and on the spot.

    Args:
        physics: of a robot on an empty floor.
        name: of the robot, for errors.

    Raises:
        TaskError: the simulation becomes unstable.
    """
    linear, angular = physics.drive.task_limits
    try:
        driven = (_drive(physics, linear, 0.0)[0], _drive(physics, 0.0, angular)[1])
    except PhysicsError as error:
        raise TaskError(f"the robot {name} cannot be simulated in steps of {physics.timestep():g} s") from error
    return DrivenSpeeds((linear, angular), driven)


def _drive(physics: Physics, linear: float, angular: float) -> tuple[float, float]:
    """Mean v along the heading (m/s) and ω (rad/s) once settled."""
    with physics.reset_context():
        physics.set_pose(Pose(0.0, 0.0, 0.0))
    physics.set_velocity_command(linear, angular)
    physics.step(round(SETTLING_TIME / physics.timestep()))
    samples = round((DRIVE_TIME - SETTLING_TIME) / _SAMPLE)
    poses = [physics.pose()]
    for _ in range(samples):
        physics.step(round(_SAMPLE / physics.timestep()))
        poses.append(physics.pose())
    steps = [
        math.cos(before.yaw) * (after.x - before.x) + math.sin(before.yaw) * (after.y - before.y)
        for before, after in itertools.pairwise(poses)
    ]
    yaw = np.unwrap([pose.yaw for pose in poses])
    return sum(steps) / (samples * _SAMPLE), float(yaw[-1] - yaw[0]) / (samples * _SAMPLE)
