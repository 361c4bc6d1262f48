"""Robots by name: those that are shipped, and any MJCF file."""

import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from tasks.errors import TaskError
from tasks.scene.loading import MODELS

PIONEER = "pioneer"  # every scene's own
SHIPPED: Mapping[str, Path] = {name: MODELS / name / f"{name}.xml" for name in (PIONEER, "turtlebot3_burger")}
ROBOTS = f"{', '.join(SHIPPED)}, or an MJCF file such as robot.xml, or robot.xml@<left joint>,<right joint>"
_SUFFIX = ".xml"


class RobotFile(NamedTuple):
    """A robot's file, and the names of the joints or actuators of its left and right wheel, where they are given."""

    path: Path
    wheels: tuple[str, ...]


def find_robot(name: str) -> RobotFile:
    """The file of a robot.

    Raises:
        TaskError: there is no such robot, or no such file.
    """
    path, wheels = _split(name)
    if not path:
        raise TaskError(f"there is no robot {reprlib.repr(name)}; there are {ROBOTS}")
    if len(wheels) not in (0, 2):
        raise TaskError(f"behind {path} stand the joints of its two wheels, {path}@<left>,<right>, not {len(wheels)}")
    try:
        is_file = Path(path).is_file()
    except (OSError, ValueError):  # a name too long, or one with a zero byte
        is_file = False
    if not is_file:
        raise TaskError(f"there is no robot file {path}; an MJCF file, .xml, is expected")
    return RobotFile(Path(path), wheels)


def full_robot_name(name: str) -> str:
    """The name of a robot that holds in every folder; TaskError where there is no such robot."""
    file = find_robot(name)
    if name in SHIPPED:
        return name
    return str(file.path.absolute()) + (f"@{','.join(file.wheels)}" if file.wheels else "")


def _split(name: str) -> tuple[str, tuple[str, ...]]:
    """Path and wheels; no path for the name of a shipped robot."""
    if name in SHIPPED:
        return str(SHIPPED[name]), ()
    path, at, wheels = name.rpartition("@")
    if at and path.lower().endswith(_SUFFIX):
        return path, tuple(wheel.strip() for wheel in wheels.split(","))
    return (name, ()) if name.lower().endswith(_SUFFIX) else ("", ())
