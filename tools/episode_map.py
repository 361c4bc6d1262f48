"""The way of recorded episodes on a map of their room: `python -m tools.episode_map FILE…`.

The room is rendered from straight above without perspective, so that the way lies exactly where it was driven. Options:

  file=here.png      where the map goes; <recording>_map.png by itself
  size=900           px of its longer side
"""

from collections.abc import Sequence
from pathlib import Path

from asddpg.errors import UserError
from asddpg.program import run
from asddpg.recording.files.reading import open_recording
from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import Picture
from tasks.room_geometry.obstacles import Obstacles
from tools.drawing.map_view import MapView, fit_view
from tools.drawing.matplotlib_check import check_matplotlib
from tools.drawing.picture_file import picture_file
from tools.recordings.arguments import files_and_options
from tools.recordings.episode_paths import Way, way_of
from tools.recordings.episode_states import EpisodeStates

OPTIONS = ("file", "size")
MIN_SIDE_PX, MAX_SIDE_PX = 200, 4000  # px
MOST = 100  # ways on a map
FAR_AWAY = (1000.0, 1000.0, 0.0)  # m


def main(arguments: Sequence[str]) -> None:
    """Run the episodes again, render, draw, write."""
    files, options = files_and_options(arguments, OPTIONS)
    size = _size(options.get("size", "900"))
    file = picture_file(options.get("file", f"{files[0].stem}_map.png"), (".png",))
    if len(files) > MOST:
        raise UserError(f"a map shows {MOST} episodes at most; {len(files)} are named")
    check_matplotlib()
    ways, view, picture, task = _seen(files, size)
    from tools.recordings.map_drawing import draw_map  # only here: -h and wrong words need no matplotlib

    draw_map(ways, view, picture, task, file)
    print(f"written to {file}")


def _seen(files: Sequence[Path], size: int) -> tuple[list[Way], MapView, Picture, str]:
    """The ways, and their room from above: as the episode left it or, of several, as the first one found it."""
    ways: list[Way] = []
    tasks = set()
    for file in files:
        states = EpisodeStates(open_recording(file))
        tasks.add(states.config.task.name)
        if len(tasks) > 1:
            raise UserError(f"a map is of one room, and the recordings are of {' and '.join(sorted(tasks))}")
        ways.append(way_of(states))
        if file == files[0]:
            if len(files) > 1:
                states.go_to(0)
            model = states.physics.model.ptr
            data = mujoco.MjData(model)
            mujoco.mj_copyData(data, model, states.physics.data.ptr)
    _put_away(model, data, with_robot=len(files) > 1)
    view = fit_view(Obstacles.from_model(model))
    return ways, view, view.render(model, data, size / max(view.width, view.height)), tasks.pop()


def _put_away(model: mujoco.MjModel, data: mujoco.MjData, with_robot: bool) -> None:
    """Take the goal, which the map draws itself, and if wanted the robot out of sight."""
    data.mocap_pos[model.body("goal").mocapid[0]] = FAR_AWAY
    if with_robot:
        start = model.joint("base").qposadr[0]
        data.qpos[start : start + 3] = FAR_AWAY
    mujoco.mj_kinematics(model, data)


def _size(value: str) -> int:
    if not (value.isascii() and value.isdigit() and MIN_SIDE_PX <= int(value) <= MAX_SIDE_PX):
        raise UserError(f"size must be a number of pixels from {MIN_SIDE_PX} to {MAX_SIDE_PX}, not {value!r}")
    return int(value)


if __name__ == "__main__":
    run(main, str(__doc__))
