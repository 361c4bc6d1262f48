"""Pictures that the tools write: their size, their file, and the renderer for them."""

import re
from pathlib import Path

from PIL import Image

from asddpg.errors import UserError
from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import OffscreenRenderer

MAX_SIDE_PX = 4096  # px


def picture_size(value: str) -> tuple[int, int]:
    """Width and height in px from a word as 1280x800; UserError where it is none."""
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", value)
    width, height = (int(match[1]), int(match[2])) if match else (0, 0)
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX):
        raise UserError(f"size must be as in 1280x800, at most {MAX_SIDE_PX}x{MAX_SIDE_PX} px, not {value!r}")
    return width, height


def picture_file(value: str, endings: tuple[str, ...] = (".png", ".jpg", ".jpeg")) -> Path:
    """Where a picture goes; UserError where the name does not end as one's."""
    file = Path(value)
    if file.suffix.lower() not in endings:
        wanted = " or ".join(ending for ending in endings if ending != ".jpeg")
        raise UserError(f"the picture's file must end in {wanted}, not {file.name!r}")
    return file


def open_renderer(model: mujoco.MjModel, width: int, height: int) -> OffscreenRenderer:
    """A renderer for pictures of up to LARGEST px, also beyond what the scene provides for."""
    limits = model.vis.global_
    limits.offwidth, limits.offheight = max(limits.offwidth, width), max(limits.offheight, height)
    return OffscreenRenderer(model, width, height)


def write(image: Image.Image, file: Path) -> None:
    """Write a picture and say where; UserError where that fails."""
    try:
        image.save(file)
    except OSError as error:
        raise UserError(f"the picture {file} cannot be written: {error}") from error
    print(f"written to {file}")
