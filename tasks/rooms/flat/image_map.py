"""Rooms drawn as pictures: dark is wall."""

from pathlib import Path

from tasks.errors import TaskError
from tasks.rooms.flat.cells import make_walls
from tasks.rooms.flat.pictures import read_picture
from tasks.rooms.limits import to_length
from tasks.rooms.room import Room

DARK = 0.5  # of white; what is darker is wall


def read_image(path: Path, scale: float) -> Room:
    """The room that a picture shows, its lower left corner at the origin; transparent pixels are floor.

    Args:
        path: of the picture.
        scale: side of a pixel, metres.

    Raises:
        TaskError: the file holds no picture, or one too large or without floor; the scale is not above 0.
    """
    picture = read_picture(path)
    try:
        dark = (picture.grey < DARK) & picture.opaque
        return Room(make_walls(dark[::-1], to_length(scale, "the metres a pixel")))  # a picture's first row is the top
    except TaskError as error:
        raise TaskError(f"{path}: {error}") from error
