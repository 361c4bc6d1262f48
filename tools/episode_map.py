"""The paths of recorded episodes on a map of their room: `python -m tools.episode_map FILE…`.

The room is rendered from straight above without perspective, so that the path lies exactly where it was driven.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from asddpg.errors import UserError, import_extra
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.reading import open_recording
from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import Picture
from tasks.options import argument, between, option
from tasks.room_geometry.obstacles import Obstacles
from tools.drawing.map_view import MapView, fit_view
from tools.drawing.picture_file import PNG_FILE
from tools.recordings.driven_paths import DrivenPath, read_path
from tools.recordings.episode_states import EpisodeStates
from tools.recordings.files import files_named

MAX_EPISODES = 100  # on a map
FAR_AWAY = (1000.0, 1000.0, 0.0)  # m


@dataclass(frozen=True)
class MapArguments:
    """The recordings on a map."""

    recordings: list[Path] = argument("Recordings, or folders of them.")
    file: Path | None = option(None, "File of the map; null names it <recording>_map.png.", PNG_FILE)
    size: int = option(900, "Its longer side, px.", between(200, 4000))


def main(arguments: Sequence[str]) -> None:
    """Run the episodes again, render, draw, write."""
    parsed = parse_arguments(MapArguments, arguments)
    files = files_named(parsed.recordings)
    if len(files) > MAX_EPISODES:
        raise UserError(f"a map shows {MAX_EPISODES} episodes at most; {len(files)} are named")
    file = parsed.file or Path(f"{files[0].stem}_map.png")
    import_extra("matplotlib", "plots", "plots")
    paths, view, picture, task = _run_again(files, parsed.size)
    from tools.recordings.map_drawing import draw_map  # only here: -h and wrong arguments need no matplotlib

    draw_map(paths, view, picture, task, file)
    print(f"written to {file}")


def _run_again(files: Sequence[Path], size: int) -> tuple[list[DrivenPath], MapView, Picture, str]:
    """The paths, and their room from above: as the episode left it or, of several, as the first one found it."""
    paths: list[DrivenPath] = []
    tasks = set()
    for file in files:
        states = EpisodeStates(open_recording(file))
        tasks.add(states.recording.facts.get("room", states.config.task.name))
        if len(tasks) > 1:
            raise UserError(f"a map is of one room, and the recordings are of {' and '.join(sorted(tasks))}")
        paths.append(read_path(states))
        if file == files[0]:
            if len(files) > 1:
                states.go_to(0)
            model = states.physics.model.ptr
            data = mujoco.MjData(model)
            mujoco.mj_copyData(data, model, states.physics.data.ptr)
    _put_away(model, data, with_robot=len(files) > 1)
    view = fit_view(Obstacles.from_model(model))
    return paths, view, view.render(model, data, size / max(view.width, view.height)), tasks.pop()


def _put_away(model: mujoco.MjModel, data: mujoco.MjData, with_robot: bool) -> None:
    """Take the goal, which the map draws itself, and if wanted the robot out of sight."""
    data.mocap_pos[model.body("goal").mocapid[0]] = FAR_AWAY
    if with_robot:
        start = model.joint("base").qposadr[0]
        data.qpos[start : start + 3] = FAR_AWAY
    mujoco.mj_kinematics(model, data)


if __name__ == "__main__":
    run(main, help_text(__doc__, MapArguments))
