"""Pictures from files, as grey values and opacity."""

import io
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from tasks.errors import TaskError
from tasks.room_geometry.grid import BoolArray
from tasks.rooms.limits import check_cells, read_bytes

# Pillow would start other programs for some of its formats.
FORMATS = ("PNG", "PPM", "BMP", "GIF", "JPEG", "TIFF", "WEBP")


@dataclass(frozen=True)
class Picture:
    """A picture.

    Attributes:
        grey: the mean of the colours, 0 for black to 1 for white: (rows, columns), the top row first.
        opaque: False where it is transparent, wholly or in part.
    """

    grey: npt.NDArray[np.float32]
    opaque: BoolArray


def read_picture(path: Path) -> Picture:
    """Read the first picture of a file.

    Raises:
        TaskError: the file is missing or too large, no such picture, or one with too many pixels.
    """
    content = io.BytesIO(read_bytes(path))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's, of damaged or huge pictures
            with Image.open(content, formats=FORMATS) as picture:
                check_cells(picture.height, picture.width)
                return _convert(picture)
    except TaskError as error:
        raise TaskError(f"{path}: {error}") from error
    except Exception as error:  # Pillow raises what the damage leads to, struct.error and zlib.error among it
        raise TaskError(f"{path} is not a picture that can be read: {', '.join(FORMATS)} can") from error


def _convert(picture: Image.Image) -> Picture:
    if picture.mode.startswith("I"):  # 16 bits
        grey = np.asarray(picture).astype(np.float32) / np.float32(65535)
        return Picture(grey, np.ones(grey.shape, dtype=bool))
    pixels = np.asarray(picture.convert("RGBA"))
    return Picture(pixels[..., :3].mean(axis=-1, dtype=np.float32) / 255, pixels[..., 3] == 255)
