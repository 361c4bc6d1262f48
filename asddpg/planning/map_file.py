"""Maps in files, as map_server of ROS keeps them: a picture, and a YAML file that names it."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image

from asddpg.atomic_write import write_whole
from asddpg.errors import UserError
from asddpg.planning.occupancy_grid import FREE, OCCUPIED, UNKNOWN, FloatArray, OccupancyGrid

OCCUPIED_THRESHOLD, FREE_THRESHOLD = 0.65, 0.196  # map_server's
_DARKNESS = {OCCUPIED: 0, FREE: 254, UNKNOWN: 205}  # grey values of map_saver
_FIELDS = ("image", "resolution", "origin")


def read_map(path: Path) -> OccupancyGrid:
    """Read the map that a YAML file describes, in map_server's trinary mode.

    Raises:
        UserError: the file is no such description, or its picture cannot be read.
        OSError: it cannot be opened.
    """
    try:
        content = yaml.safe_load(path.read_bytes())
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"{path} is not the YAML file of a map") from error
    missing = [name for name in _FIELDS if not isinstance(content, dict) or name not in content]
    if missing:
        raise UserError(f"{path} is not a map's YAML file: it has no {missing[0]}; it needs {', '.join(_FIELDS)}")
    try:
        resolution = float(content["resolution"])
        x, y, yaw = (float(each) for each in content["origin"])
        occupied_from = float(content.get("occupied_thresh", OCCUPIED_THRESHOLD))
        free_to = float(content.get("free_thresh", FREE_THRESHOLD))
    except (TypeError, ValueError) as error:
        raise UserError(f"{path}: resolution is a number, and origin three: [x, y, yaw]") from error
    if not resolution > 0.0 or not np.isfinite([resolution, x, y]).all():
        raise UserError(f"{path}: resolution must be above 0, and origin finite")
    if yaw:
        raise UserError(f"{path}: the map is turned by {yaw:g} rad, and only maps along the axes can be used")
    darkness = _read_darkness(path.parent / str(content["image"]), bool(content.get("negate", 0)))
    cells = np.full(darkness.shape, UNKNOWN, dtype=np.int8)
    cells[darkness > occupied_from] = OCCUPIED
    cells[darkness < free_to] = FREE
    return OccupancyGrid(cells[::-1], resolution, (x, y))  # a picture's first row is the map's last


def _read_darkness(path: Path, is_negated: bool) -> FloatArray:
    """0 for white to 1 for black, (rows, columns), the top row first."""
    with path.open("rb") as file:
        try:
            grey = np.asarray(Image.open(file).convert("L"), dtype=np.float64) / 255.0
        except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:  # Pillow's, by the damage
            raise UserError(f"{path} is not a picture that can be read") from error
    return grey if is_negated else 1.0 - grey


def write_map(grid: OccupancyGrid, path: Path) -> None:
    """Write a map as `path`, which ends in .yaml, and a PNG beside it.

    Raises:
        UserError: the name has another ending.
        OSError: a file could not be written.
    """
    if path.suffix != ".yaml":
        raise UserError(f"a map's file ends in .yaml, not in {path.suffix or 'nothing'}: {path}")
    grey = np.full(grid.shape, _DARKNESS[UNKNOWN], dtype=np.uint8)
    grey[grid.occupied] = _DARKNESS[OCCUPIED]
    grey[~grid.unknown & (grid.cells < 100.0 * FREE_THRESHOLD)] = _DARKNESS[FREE]
    picture = io.BytesIO()
    Image.fromarray(grey[::-1]).save(picture, "png")
    image = path.with_suffix(".png")
    write_whole(image, picture.getvalue())
    content: dict[str, Any] = {
        "image": image.name,
        "resolution": float(grid.resolution),  # YAML knows no NumPy
        "origin": [*map(float, grid.origin), 0.0],
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESHOLD,
        "free_thresh": FREE_THRESHOLD,
    }
    write_whole(path, yaml.safe_dump(content, sort_keys=False).encode())
