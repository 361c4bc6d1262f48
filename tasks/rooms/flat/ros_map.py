"""Rooms from maps of ROS: the YAML file and the picture of map_server."""

from enum import StrEnum
from pathlib import Path
from typing import Any

import numpy as np
from scipy import ndimage

from tasks.errors import TaskError
from tasks.physics import Pose
from tasks.room_geometry.grid import BoolArray
from tasks.rooms.flat.cells import make_walls
from tasks.rooms.flat.pictures import Picture, read_picture
from tasks.rooms.flat.plain_yaml import read_mapping
from tasks.rooms.limits import to_length, to_number
from tasks.rooms.room import Room

OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.196  # map_server's
RAW_OCCUPIED = 100  # of mode raw; what is above it is unknown
_FIELDS = ("image", "resolution", "origin")
_TRUE, _FALSE = ("1", "true", "yes", "on"), ("0", "false", "no", "off", "")


class Mode(StrEnum):
    """How map_server reads a pixel."""

    TRINARY = "trinary"
    SCALE = "scale"
    RAW = "raw"


def read_ros_map(path: Path) -> Room:
    """The room that a map shows.

    Unknown cells that reach the picture's border, past other unknown cells, lie outside and are solid: nothing says
    that there is a floor, and they close gaps in walls. Unknown cells in the midst of a room are floor, as for planners
    of ROS: walls there would be ones that no sensor saw.

    Args:
        path: of the YAML file; the picture lies in its folder, or below.

    Raises:
        TaskError: a file is missing, broken or too large, or a value is out of range.
    """
    content = read_mapping(path)
    try:
        missing = [name for name in _FIELDS if name not in content]
        if missing:
            raise TaskError(f"it has no {missing[0]}; a map of ROS needs {', '.join(_FIELDS)}")
        resolution, origin = to_length(content["resolution"], "resolution"), _read_origin(content["origin"])
        picture = read_picture(_find_image(path, content["image"]))
        occupied, unknown = _classify(picture, content)
        solid = occupied | _reaching_border(unknown)
        return Room(make_walls(solid[::-1], resolution, origin))  # a picture's first row is the top
    except TaskError as error:
        raise TaskError(f"{path}: {error}") from error


def _read_origin(value: object) -> Pose:
    if not isinstance(value, list) or len(value) not in (2, 3):
        raise TaskError("origin must be three numbers, [x, y, yaw]")
    return Pose(*(to_number(each, "a number of origin") for each in [*value, 0.0][:3]))


def _find_image(path: Path, name: object) -> Path:
    """The picture; one that map_saver named by a path of another machine lies beside the YAML file."""
    folder = path.parent.resolve()
    if not isinstance(name, str) or not name or "\0" in name:
        raise TaskError("image must be the name of a picture")
    image = (folder / name).resolve()
    if not image.is_relative_to(folder) and Path(name).is_absolute():
        image = (folder / Path(name).name).resolve()
    if not image.is_relative_to(folder):
        raise TaskError(f"image must lie in the map's folder, not at {name}")
    return image


def _classify(picture: Picture, content: dict[str, Any]) -> tuple[BoolArray, BoolArray]:
    """Occupied and unknown cells.

    Transparent pixels are unknown, in modes trinary and scale. Between the thresholds a cell is unknown in mode
    trinary, and free in mode scale: costmaps take only the full value for an obstacle.
    """
    mode = content.get("mode", Mode.TRINARY)
    if mode not in list(Mode):
        raise TaskError(f"mode must be one of {', '.join(Mode)}")
    is_negated = str(content.get("negate", 0)).lower()
    if is_negated not in (*_TRUE, *_FALSE):
        raise TaskError("negate must be 0 or 1")
    if mode == Mode.RAW:
        value = np.round(picture.grey * 255)
        return value == RAW_OCCUPIED, value > RAW_OCCUPIED
    occupied_above = to_number(content.get("occupied_thresh", OCCUPIED_THRESHOLD), "occupied_thresh", 0.0, 1.0)
    free_below = to_number(content.get("free_thresh", FREE_THRESHOLD), "free_thresh", 0.0, 1.0)
    darkness = picture.grey if is_negated in _TRUE else 1.0 - picture.grey
    occupied = (darkness > occupied_above) & picture.opaque
    if mode == Mode.SCALE:
        return occupied, ~picture.opaque
    return occupied, ~occupied & ((darkness >= free_below) | ~picture.opaque)


def _reaching_border(cells: BoolArray) -> BoolArray:
    """Those of some cells that a chain of them, side by side, links to the grid's border."""
    pieces, count = ndimage.label(cells)
    reaches = np.zeros(count + 1, dtype=bool)
    for line in (pieces[0], pieces[-1], pieces[:, 0], pieces[:, -1]):
        reaches[line] = True
    reaches[0] = False
    return np.asarray(reaches[pieces])
