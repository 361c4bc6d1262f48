"""Pictures that the tools write: their size, their file, and the renderer for them."""

import io
import re
from pathlib import Path

from PIL import Image

from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from tasks.graphics.headless import mujoco
from tasks.graphics.rendering import OffscreenRenderer
from tasks.options import Range

MAX_SIDE_PX = 4096  # px


def picture_size(text: str) -> tuple[int, int]:
    """Width and height in px of a text such as 1280x800; 0 and 0 of any other."""
    match = re.fullmatch(r"([0-9]{1,5})x([0-9]{1,5})", text)
    return (int(match[1]), int(match[2])) if match else (0, 0)


PICTURE_SIZE = Range(
    lambda text: all(0 < side <= MAX_SIDE_PX for side in picture_size(text)),
    f"as in 1280x800, at most {MAX_SIDE_PX}x{MAX_SIDE_PX} px",
)
PNG_FILE = Range(lambda path: path.suffix.lower() == ".png", "a path that ends in .png")
PICTURE_FILE = Range(lambda path: path.suffix.lower() in (".png", ".jpg", ".jpeg"), "a path that ends in .png or .jpg")


def open_renderer(model: mujoco.MjModel, width: int, height: int) -> OffscreenRenderer:
    """A renderer for pictures of up to MAX_SIDE_PX, also beyond what the scene provides for."""
    limits = model.vis.global_
    limits.offwidth, limits.offheight = max(limits.offwidth, width), max(limits.offheight, height)
    return OffscreenRenderer(model, width, height)


def write(image: Image.Image, file: Path) -> None:
    """Write a picture and say where; UserError where that fails."""
    try:
        content = io.BytesIO()
        image.save(content, Image.registered_extensions()[file.suffix.lower()])
        write_whole(file, content.getbuffer())
    except OSError as error:
        raise UserError(f"the picture {file} cannot be written: {error}") from error
    print(f"written to {file}")
