"""A picture of a room or of the robot: `python -m tools.picture nav_complex [camera] [file.png]`.

The first word is a task, `pioneer` for the robot alone, or a path to any .xml scene. Options:

  camera=top         a camera of the scene, or free for the whole of it
  file=here.png      where the picture goes; <scene>_<camera>.png by itself
  size=1280x800      in pixels
  shadows=true       or false, as observers of the tasks see it
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import tasks
from asddpg.errors import UserError
from asddpg.program import run
from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import FREE, Picture
from tasks.scene.loading import load_model
from tools.drawing.picture_file import open_renderer, picture_file, picture_size, write
from tools.robot.scene_argument import ROBOT, scene_file

OPTIONS = ("camera", "file", "size", "shadows")
SHADOW_SIZE = 8192  # px of the shadow's map: fine enough for a whole room
SEED = 3  # of the goal in a task's picture


@dataclass(frozen=True)
class Wish:
    """What a picture is asked to be."""

    scene: str
    camera: str
    file: Path
    width: int
    height: int
    shadows: bool


def wish(arguments: Sequence[str]) -> Wish:
    """Read the command line's words; UserError where one is wrong."""
    plain = [argument for argument in arguments if "=" not in argument]
    if not 1 <= len(plain) <= 3:
        raise UserError(
            f"name a scene ({', '.join(tasks.ALL_TASKS)}, {ROBOT}, or a path to an .xml), then if wanted a camera, "
            "a file, and options, as in size=1280x800"
        )
    options = dict(zip(("camera", "file"), plain[1:], strict=False))
    for argument in (argument for argument in arguments if "=" in argument):
        name, value = argument.split("=", 1)
        if name not in OPTIONS:
            raise UserError(f"there is no option {name!r}; there are {', '.join(OPTIONS)}")
        if name in options:
            raise UserError(f"{name} is given twice, as {options[name]} and {value}")
        options[name] = value
    camera = options.get("camera", "portrait" if plain[0] == ROBOT else FREE)
    file = picture_file(options.get("file", f"{Path(plain[0]).stem}_{camera}.png"))
    width, height = picture_size(options.get("size", "1280x800"))
    return Wish(plain[0], camera, file, width, height, _truth("shadows", options.get("shadows", "true")))


def _truth(name: str, value: str) -> bool:
    if value not in ("true", "false"):
        raise UserError(f"{name} must be true or false, not {value!r}")
    return value == "true"


def render(asked: Wish) -> Picture:
    """The picture, uint8 (height, width, 3)."""
    model, data = _state(asked.scene)
    _set_shadows(model, data, asked.shadows)
    renderer = open_renderer(model, asked.width, asked.height)
    try:
        return renderer.render(data, asked.camera)
    finally:
        renderer.close()


def _set_shadows(model: mujoco.MjModel, data: mujoco.MjData, wanted: bool) -> None:
    model.vis.quality.shadowsize = SHADOW_SIZE
    model.light_castshadow[:] = wanted
    # A directional light's shadows end `extent` from its axis: lay the axis through the middle of the scene, and let
    # them reach its corners.
    fixed = model.geom_pos[(model.geom_bodyid == 0) & (model.geom_type != mujoco.mjtGeom.mjGEOM_PLANE)]
    if len(fixed):
        model.stat.extent = max(model.stat.extent, 1.6 * np.hypot(fixed[:, 0], fixed[:, 1]).max())
    for light in np.flatnonzero(model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL):
        data.light_xpos[light] = model.stat.center - model.stat.extent * data.light_xdir[light]


def _state(scene: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A scene at its beginning: a task's with a goal drawn, any other in its first keyframe, if it has one."""
    if scene in tasks.ALL_TASKS:
        environment = tasks.load(scene, random=SEED)
        environment.reset()
        return environment.physics.model.ptr, environment.physics.data.ptr
    model = load_model(scene_file(scene))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


def main(arguments: Sequence[str]) -> None:
    """Render and write."""
    asked = wish(arguments)
    write(Image.fromarray(render(asked)), asked.file)


if __name__ == "__main__":
    run(main, str(__doc__))
