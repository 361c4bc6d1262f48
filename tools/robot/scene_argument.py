"""The scene argument of tools: a task's scene, the robot alone, or any MJCF file."""

from pathlib import Path

import tasks
from tasks.options import Range
from tasks.scene.loading import MODELS, scene_path

ROBOT = "pioneer"
ROBOT_SCENE = MODELS / "pioneer" / "scene.xml"
SCENE = Range(
    lambda name: name in (*tasks.ALL_TASKS, ROBOT) or name.endswith(".xml"),
    f"{', '.join(tasks.ALL_TASKS)}, {ROBOT} or a path to an .xml",
)


def scene_file(name: str) -> Path:
    """The file of a scene that SCENE includes."""
    if name in tasks.ALL_TASKS:
        return scene_path(name)
    return ROBOT_SCENE if name == ROBOT else Path(name)
