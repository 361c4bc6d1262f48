"""The arguments scene and robot of tools: a task's scene, a robot alone, a room, or any MJCF file."""

from pathlib import Path
from typing import Any

import mujoco

from tasks.options import Range, option
from tasks.registry import ROOM_TASKS, task_model
from tasks.robots.names import PIONEER, ROBOTS, SHIPPED
from tasks.robots.opening import load_robot
from tasks.rooms.reading import ROOMS, is_room
from tasks.scene.loading import MODELS, load_model

PIONEER_SCENE = MODELS / "pioneer" / "scene.xml"
SCENE = Range(
    lambda name: name in (*ROOM_TASKS, *SHIPPED) or is_room(name),
    f"{', '.join((*ROOM_TASKS, *SHIPPED))}, a path to an .xml scene, or {ROOMS}",
)


def robot_option() -> Any:
    """The field `robot`."""
    return option(PIONEER, f"The robot: {ROBOTS}.")


def scene_model(name: str, robot: str = PIONEER) -> mujoco.MjModel:
    """The compiled scene that SCENE includes; with the Pioneer an MJCF file as it is, with or without a robot.

    Args:
        name: of the scene; a robot's is the robot alone.
        robot: that is in it.

    Raises:
        TaskError: it cannot be read.
    """
    if name in SHIPPED:
        alone = name if robot == PIONEER else robot
        return load_model(PIONEER_SCENE) if alone == PIONEER else load_robot(alone).model.ptr
    if name.endswith(".xml") and robot == PIONEER:
        return load_model(Path(name))
    return task_model(name, robot=robot)
