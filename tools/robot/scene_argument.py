"""The scene argument of tools: a task's scene, the robot alone, a room, or any MJCF file."""

from pathlib import Path

import mujoco

import tasks
from tasks.options import Range
from tasks.registry import task_model
from tasks.rooms.reading import ROOMS, is_room
from tasks.scene.loading import MODELS, load_model, scene_path

ROBOT = "pioneer"
ROBOT_SCENE = MODELS / "pioneer" / "scene.xml"
SCENE = Range(
    lambda name: name in (*tasks.ALL_TASKS, ROBOT) or is_room(name),
    f"{', '.join(tasks.ALL_TASKS)}, {ROBOT}, a path to an .xml scene, or {ROOMS}",
)


def scene_model(name: str) -> mujoco.MjModel:
    """The compiled scene that SCENE includes; an MJCF file as it is, with or without a robot.

    Raises:
        TaskError: it cannot be read.
    """
    if name in tasks.ALL_TASKS:
        return load_model(scene_path(name))
    if name == ROBOT:
        return load_model(ROBOT_SCENE)
    return load_model(Path(name)) if name.endswith(".xml") else task_model(name)
