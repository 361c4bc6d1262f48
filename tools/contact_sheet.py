"""Small pictures of recorded episodes on one sheet: `python -m tools.contact_sheet FILE… or FOLDER`.

Of one recording, moments from beginning to end; of several, or of a folder of them, how each ended. Options:

  camera=top         chase, onboard, top, or free for the whole room
  frames=12          how many moments, of one recording
  columns=4          pictures in a row; by itself so many that the sheet is about twice as wide as high
  size=320x320       of each picture, in pixels
  file=here.png      where the sheet goes; <recording or folder>_sheet.png by itself
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

from PIL import Image

from asddpg.errors import UserError
from asddpg.program import run
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.path_message import DRIVER_COLOURS
from asddpg.recording.pictures.caption import OUTCOME_COLOURS, Colour, captioned
from tools.drawing.picture_file import open_renderer, picture_file, picture_size, write
from tools.recordings.arguments import files_and_options
from tools.recordings.episode_states import EpisodeStates

OPTIONS = ("camera", "frames", "columns", "size", "file")
MOST = 400  # pictures on a sheet
GAP = 4  # px


def main(arguments: Sequence[str]) -> None:
    """Render, lay out, write."""
    files, options = files_and_options(arguments, OPTIONS)
    frames, columns = (
        _number(name, options.get(name, default)) for name, default in (("frames", "12"), ("columns", "0"))
    )
    if len(files) > MOST:
        raise UserError(f"a sheet holds {MOST} pictures at most; {len(files)} recordings are named")
    if len(files) > 1 and "frames" in options:
        raise UserError(f"frames= is for one recording; of several, {len(files)} here, the sheet shows how each ended")
    width, height = picture_size(options.get("size", "320x320"))
    stem = files[0].stem if len(files) == 1 else files[0].resolve().parent.name
    file = picture_file(options.get("file", f"{stem}_sheet.png"))
    tiles = _tiles(files, options.get("camera", "top"), width, height, frames)
    write(sheet(list(tiles), columns), file)


def sheet(tiles: Sequence[Image.Image], columns: int = 0) -> Image.Image:
    """Pictures of one size in rows, from left to right; 0 columns for a sheet about twice as wide as high."""
    width, height = tiles[0].size
    is_given = columns > 0
    columns = min(columns or math.ceil(math.sqrt(2 * len(tiles) * height / width)), len(tiles))
    rows = math.ceil(len(tiles) / columns)
    columns = columns if is_given else math.ceil(len(tiles) / rows)  # no nearly empty last row
    whole = Image.new("RGB", (columns * (width + GAP) - GAP, rows * (height + GAP) - GAP), "white")
    for index, tile in enumerate(tiles):
        row, column = divmod(index, columns)
        whole.paste(tile, (column * (width + GAP), row * (height + GAP)))
    return whole


def _tiles(files: Sequence[Path], camera: str, width: int, height: int, frames: int) -> Iterator[Image.Image]:
    model, renderer = None, None
    try:
        for file in files:
            states = EpisodeStates(open_recording(file))
            if states.physics.model.ptr is not model:
                if renderer is not None:
                    renderer.close()
                model = states.physics.model.ptr
                renderer = open_renderer(model, width, height)
            assert renderer is not None
            wanted = _moments(len(states.steps), frames) if len(files) == 1 else {len(states.steps)}
            for count, step in states:
                if count in wanted:
                    image = Image.fromarray(renderer.render(states.physics.data.ptr, camera))
                    yield captioned(
                        image, *_caption(states, count, step["driver"] if step else "", len(files) == 1), above=True
                    )
    finally:
        if renderer is not None:
            renderer.close()


def _moments(steps: int, frames: int) -> set[int]:
    """So many numbers of steps, evenly from 0 to the last."""
    return {round(index * steps / max(frames - 1, 1)) for index in range(frames)} if frames > 1 else {steps}


def _caption(states: EpisodeStates, count: int, driver: str, is_one: bool) -> tuple[str, Colour | None]:
    is_end = count == len(states.steps)
    number = int(states.recording.facts["episode"])
    if is_end:
        which = f"{states.time(count):.1f} s" if is_one else f"episode {number}"
        when = "" if is_one else f" after {states.time(count):.1f} s"
        return f"{which} · {states.outcome}{when}", OUTCOME_COLOURS.get(states.outcome)
    return f"{states.time(count):.1f} s · {driver or 'start'}", DRIVER_COLOURS.get(driver)


def _number(name: str, value: str) -> int:
    if not (value.isascii() and value.isdigit() and int(value) <= MOST and (int(value) or name == "columns")):
        raise UserError(f"{name} must be a whole number from 1 to {MOST}, not {value!r}")
    return int(value)


if __name__ == "__main__":
    run(main, str(__doc__))
