"""A picture of a room or of the robot: `python -m tools.picture nav_complex`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

import tasks
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import FREE, Picture
from tasks.options import argument, option
from tasks.robots.names import SHIPPED
from tasks.rooms.reading import short_name
from tools.drawing.picture_file import PICTURE_FILE, PICTURE_SIZE, open_renderer, picture_size, write
from tools.robot.scene_argument import SCENE, robot_option, scene_model

SHADOW_SIZE = 8192  # px of the shadow's map: fine enough for a whole room
SEED = 3  # of the goal in a task's picture


@dataclass(frozen=True)
class PictureArguments:
    """The scene to draw, and how."""

    scene: str = argument("A task, a robot's name for it alone, an .xml scene, or a room.", values=SCENE)
    robot: str = robot_option()
    camera: str | None = option(
        None, "A camera of the scene, or free for the whole of it; null takes free, of the robot portrait."
    )
    file: Path | None = option(None, "File of the picture; null names it <scene>_<camera>.png.", PICTURE_FILE)
    size: str = option("1280x800", "Width and height, px.", PICTURE_SIZE)
    shadows: bool = option(True, "Whether lights cast shadows; the tasks' own cameras see none.")


def render(parsed: PictureArguments, camera: str) -> Picture:
    """The picture, uint8 (height, width, 3)."""
    model, data = _state(parsed.scene, parsed.robot)
    _set_shadows(model, data, parsed.shadows)
    renderer = open_renderer(model, *picture_size(parsed.size))
    try:
        return renderer.render(data, camera)
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


def _state(scene: str, robot: str) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """A scene at its beginning: a task's with a goal drawn, any other in its first keyframe, if it has one."""
    if scene in tasks.ALL_TASKS:
        environment = tasks.load(scene, random=SEED, config={"robot": robot})
        environment.reset()
        return environment.physics.model.ptr, environment.physics.data.ptr
    model = scene_model(scene, robot)
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


def main(arguments: Sequence[str]) -> None:
    """Render and write."""
    parsed = parse_arguments(PictureArguments, arguments)
    camera = parsed.camera or ("portrait" if parsed.scene in SHIPPED else FREE)
    write(Image.fromarray(render(parsed, camera)), parsed.file or Path(f"{short_name(parsed.scene)}_{camera}.png"))


if __name__ == "__main__":
    run(main, help_text(__doc__, PictureArguments))
