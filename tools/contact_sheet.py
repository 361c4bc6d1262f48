"""Small pictures of recorded episodes on one sheet: `python -m tools.contact_sheet runs/mine/episodes`.

Of one recording, moments from beginning to end; of several, or of a folder of them, how each ended.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from asddpg.errors import UserError
from asddpg.options.help_text import help_text
from asddpg.options.parsing import parse_arguments
from asddpg.program import run
from asddpg.recording.files.reading import open_recording
from asddpg.recording.messages.path_message import DRIVER_COLOURS
from asddpg.recording.pictures.caption import OUTCOME_COLOURS, Colour, captioned
from tasks.options import argument, between, option
from tools.drawing.picture_file import PICTURE_FILE, PICTURE_SIZE, open_renderer, picture_size, write
from tools.recordings.episode_states import EpisodeStates
from tools.recordings.files import files_named

MAX_PICTURES = 400  # on a sheet
FRAMES = 12  # of one recording, without frames=
GAP = 4  # px


@dataclass(frozen=True)
class SheetArguments:
    """The recordings on a sheet, and how they are shown."""

    recordings: list[Path] = argument("Recordings, or folders of them.")
    camera: str = option("top", "chase, onboard, top, or free for the whole room.")
    frames: int | None = option(None, "Moments of one recording; null shows 12.", between(1, MAX_PICTURES))
    columns: int | None = option(
        None, "Pictures in a row; null makes the sheet about twice as wide as high.", between(1, MAX_PICTURES)
    )
    size: str = option("320x320", "Width and height of each picture, px.", PICTURE_SIZE)
    file: Path | None = option(None, "File of the sheet; null names it <recording or folder>_sheet.png.", PICTURE_FILE)


def main(arguments: Sequence[str]) -> None:
    """Render, lay out, write."""
    parsed = parse_arguments(SheetArguments, arguments)
    files = files_named(parsed.recordings)
    if len(files) > MAX_PICTURES:
        raise UserError(f"a sheet holds {MAX_PICTURES} pictures at most; {len(files)} recordings are named")
    if len(files) > 1 and parsed.frames:
        raise UserError(f"frames= is for one recording; of several, {len(files)} here, the sheet shows how each ended")
    stem = files[0].stem if len(files) == 1 else files[0].resolve().parent.name
    tiles = _tiles(files, parsed.camera, *picture_size(parsed.size), parsed.frames or FRAMES)
    write(sheet(list(tiles), parsed.columns or 0), parsed.file or Path(f"{stem}_sheet.png"))


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


if __name__ == "__main__":
    run(main, help_text(__doc__, SheetArguments))
