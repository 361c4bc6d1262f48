"""The scene argument of tools: a task's scene, the robot alone, or any MJCF file."""

from pathlib import Path

import tasks
from asddpg.errors import UserError
from tasks.scene.loading import MODELS, scene_path

ROBOT = "pioneer"
ROBOT_SCENE = MODELS / "pioneer" / "scene.xml"


def scene_file(argument: str) -> Path:
    """The scene file that an argument names.

    Raises:
        UserError: it names neither a task, nor the robot, nor an .xml file.
    """
    if argument in tasks.ALL_TASKS:
        return scene_path(argument)
    if argument == ROBOT:
        return ROBOT_SCENE
    if argument.endswith(".xml"):
        return Path(argument)
    raise UserError(
        f"there is no scene {argument!r}; there are {', '.join(tasks.ALL_TASKS)}, {ROBOT}, or a path to an .xml"
    )
