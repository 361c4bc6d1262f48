"""A picture of a moment of a recorded episode: `python -m tools.episode_frame FILE step=12`.

The recorded actions are run again, so any camera can look at it, whether or not pictures were recorded. Options:

  step=last          how many steps have been made: 0 for the beginning, last for the end
  time=2.4           the same in simulated seconds
  camera=chase       chase, onboard, top, or free for the whole room
  file=here.png      where the picture goes; <recording>_<camera>_<step>.png by itself
  size=1280x800      in pixels
  caption=true       or false
  show=scan,path     what Foxglove shows besides: where the laser's beams end, the path so far; nothing by itself
"""

import math
from collections.abc import Sequence

from PIL import Image

from asddpg.errors import UserError
from asddpg.program import run
from asddpg.recording.pictures.caption import captioned
from tasks.graphics.headless import mujoco
from tools.drawing.picture_file import open_renderer, picture_file, picture_size, write
from tools.recordings.arguments import single
from tools.recordings.episode_states import EpisodeStates, StepRecord
from tools.recordings.overlay import Place, Stretch, draw_path, draw_scan, scan_points

OPTIONS = ("step", "time", "camera", "file", "size", "caption", "show")
SHOWN = ("scan", "path")


def main(arguments: Sequence[str]) -> None:
    """Run the episode up to that moment, render, write."""
    recording, options = single(arguments, OPTIONS)
    camera = options.get("camera", "chase")
    width, height = picture_size(options.get("size", "1280x800"))
    given = picture_file(options["file"]) if "file" in options else None
    if options.get("caption", "true") not in ("true", "false"):
        raise UserError(f"caption must be true or false, not {options['caption']!r}")
    overlays = _shown(options.get("show", ""))
    states = EpisodeStates(recording)
    count = _count(options, states)
    step, path = _run_to(count, states)
    renderer = open_renderer(states.physics.model.ptr, width, height)
    try:
        picture = renderer.render(
            states.physics.data.ptr, camera, lambda scene: _decorate(scene, overlays, states, path)
        )
        image = Image.fromarray(picture)
    finally:
        renderer.close()
    if options.get("caption", "true") == "true":
        image = captioned(image, *states.caption(count, step))
    write(image, given or picture_file(f"{recording.path.stem}_{camera}_{count}.png"))


def _shown(value: str) -> list[str]:
    wanted = [name for name in value.split(",") if name]
    unknown = [name for name in wanted if name not in SHOWN]
    if unknown:
        raise UserError(f"show must be some of {', '.join(SHOWN)}, not {unknown[0]!r}")
    return wanted


def _run_to(count: int, states: EpisodeStates) -> tuple[StepRecord | None, list[Stretch]]:
    """Run the episode up to the end of that many steps; gives the last of them, and the path."""
    places: list[Place] = []
    for reached, step in states:
        places.append(states.physics.pose()[:2])
        if reached == count:
            return step, [
                (each["driver"], places[index : index + 2]) for index, each in enumerate(states.steps[:count])
            ]
    raise UserError(states.no_such_step(count))


def _decorate(scene: mujoco.MjvScene, overlays: Sequence[str], states: EpisodeStates, path: Sequence[Stretch]) -> None:
    if "path" in overlays:
        draw_path(scene, path)
    if "scan" in overlays:
        laser = states.physics.data.ptr.body("laser")
        ranges = states.physics.ranges()
        draw_scan(scene, scan_points(laser.xpos.copy(), laser.xmat.reshape(3, 3).copy(), ranges))


def _count(options: dict[str, str], states: EpisodeStates) -> int:
    """How many steps are made before the picture."""
    if "step" in options and "time" in options:
        raise UserError("step= and time= name the same: give one of them")
    if "time" in options:
        return round(_number("time", options["time"]) / states.time(1))
    step = options.get("step", "last")
    return len(states.steps) if step == "last" else round(_number("step", step))


def _number(name: str, value: str) -> float:
    try:
        number = float(value)
    except ValueError:
        number = math.nan
    if not 0 <= number < 1e6 or (name == "step" and number != int(number)):
        wanted = "seconds, as in time=2.4" if name == "time" else "a number of steps, as in step=12, or last"
        raise UserError(f"{name} must be {wanted}, not {value!r}")
    return number


if __name__ == "__main__":
    run(main, str(__doc__))
