"""A picture of a moment of a recorded episode: `python -m tools.episode_frame FILE step=12`.

The recorded actions are run again, so any camera can look at it, whether or not pictures were recorded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from asddpg.errors import UserError
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.pictures.caption import captioned
from tasks.graphics.headless import mujoco
from tasks.options import NOT_NEGATIVE, argument, between, option, some_of
from tools.drawing.picture_file import PICTURE_FILE, PICTURE_SIZE, open_renderer, picture_size, write
from tools.recordings.episode_states import EpisodeStates
from tools.recordings.files import open_single
from tools.recordings.overlay import Place, Stretch, draw_path, draw_scan, read_scans

OVERLAYS = ("scan", "path")


@dataclass(frozen=True)
class FrameArguments:
    """The moment of an episode, and how it is shown."""

    recording: Path = argument("A recording, or a folder that holds one.")
    step: int | None = option(
        None, "Steps made before the picture, 0 for the beginning; null for the end.", NOT_NEGATIVE
    )
    time: float | None = option(None, "The same in simulated seconds.", between(0, 10**6))
    camera: str = option("chase", "chase, onboard, top, or free for the whole room.")
    file: Path | None = option(
        None, "File of the picture; null names it <recording>_<camera>_<step>.png.", PICTURE_FILE
    )
    size: str = option("1280x800", "Width and height, px.", PICTURE_SIZE)
    caption: bool = option(True, "Whether step, time and driver stand below.")
    show: list[str] = option(
        [],
        "What Foxglove shows besides: scan, where the beams of its last scan ended, and path, the path so far.",
        some_of(*OVERLAYS),
    )


def main(arguments: Sequence[str]) -> None:
    """Run the episode up to that moment, render, write."""
    parsed = parse_arguments(FrameArguments, arguments)
    recording = open_single(parsed.recording)
    states = EpisodeStates(recording)
    count = _count(parsed, states)
    places: list[Place] = []
    step = states.go_to(count, lambda: places.append(states.physics.pose()[:2]))
    path = [(each["driver"], places[index : index + 2]) for index, each in enumerate(states.steps[:count])]
    renderer = open_renderer(states.physics.model.ptr, *picture_size(parsed.size))
    try:
        picture = renderer.render(
            states.physics.data.ptr, parsed.camera, lambda scene: _decorate(scene, parsed.show, states, path)
        )
        image = Image.fromarray(picture)
    finally:
        renderer.close()
    if parsed.caption:
        image = captioned(image, *states.caption(count, step))
    write(image, parsed.file or Path(f"{recording.path.stem}_{parsed.camera}_{count}.png"))


def _decorate(scene: mujoco.MjvScene, overlays: Sequence[str], states: EpisodeStates, path: Sequence[Stretch]) -> None:
    if "path" in overlays:
        draw_path(scene, path)
    if "scan" in overlays:
        draw_scan(scene, read_scans(states.recording)[len(path)])


def _count(parsed: FrameArguments, states: EpisodeStates) -> int:
    """Steps made before the picture."""
    if parsed.step is not None and parsed.time is not None:
        raise UserError("step= and time= name the same: give one of them")
    if parsed.time is not None:
        return round(parsed.time / states.time(1))
    return len(states.steps) if parsed.step is None else parsed.step


if __name__ == "__main__":
    run(main, help_text(__doc__, FrameArguments))
