"""Rooms by name: a file that holds one, or a generated one such as cylinders:17."""

import os
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path

from tasks.errors import TaskError
from tasks.rooms.flat.image_map import read_image
from tasks.rooms.flat.text_maze import read_maze
from tasks.rooms.flat.yaml_room import read_yaml
from tasks.rooms.generators.catalogue import GENERATORS, generated_room
from tasks.rooms.room import Room
from tasks.rooms.solid.mjcf_room import read_mjcf
from tasks.rooms.solid.sdf_world import read_world

MODEL_PATH = "GAZEBO_MODEL_PATH"  # Gazebo's, of the folders that hold models


def _read_world(path: Path) -> Room:
    search = [Path(folder) for folder in os.environ.get(MODEL_PATH, "").split(os.pathsep) if folder]
    return read_world(path, search)


READERS: Mapping[str, Callable[[Path], Room]] = {
    ".xml": read_mjcf,
    ".world": _read_world,
    ".sdf": _read_world,
    ".yaml": read_yaml,
    ".yml": read_yaml,
    ".txt": read_maze,
}
PICTURES = (".png", ".pgm", ".jpg", ".jpeg", ".bmp")
ROOMS = (
    f"a file of a room ({', '.join(READERS)}; a picture with its metres a pixel, such as plan.png@0.05) or a generated "
    f"room, {', '.join(f'{name}:<number>' for name in GENERATORS)}"
)
_GENERATED = re.compile(r"([a-z_]+):([0-9]{1,9})")
_PICTURE = re.compile(r"(.+)@([0-9.eE+-]+)", re.DOTALL)


def is_room(name: str) -> bool:
    """Whether a name has the form of a room's, not of a registered task's: the file may be missing."""
    return _generated(name) is not None or _suffix(name) in (*READERS, *PICTURES)


def find_room(name: str) -> Room:
    """The room of a name.

    Raises:
        TaskError: there is no such file, or it holds no room.
    """
    generated = _generated(name)
    if generated is not None:
        return generated_room(*generated)
    path = Path(_split(name)[0])
    try:
        status = path.stat()
        if not path.is_file():
            raise TaskError(f"{path} is no file")
    except FileNotFoundError as error:
        raise TaskError(f"there is no file {path}") from error
    except (OSError, ValueError) as error:  # a name too long, one with a zero byte, a folder that is closed
        raise TaskError(f"the file {path} cannot be read: {error}") from error
    return _read(full_name(name), status.st_mtime_ns, status.st_size)


def full_name(name: str) -> str:
    """The name of a room that holds in every folder."""
    if _generated(name) is not None:
        return name
    path, scale = _split(name)
    return str(Path(path).absolute()) + (f"@{scale}" if scale else "")


def short_name(name: str) -> str:
    """A name for files' names: of letters, digits and _."""
    stem = Path(_split(name)[0]).stem if _generated(name) is None else name
    return re.sub(r"\W+", "_", stem)[:60] or "room"


@lru_cache(maxsize=16)
def _read(name: str, _changed: int, _size: int) -> Room:
    """Read a file once, until it changes."""
    path, scale = _split(name)
    if _suffix(name) not in PICTURES:
        return READERS[_suffix(name)](Path(path))
    try:
        metres = float(scale)
    except ValueError as error:
        raise TaskError(f"{path} is a picture: the metres of a pixel stand behind it, such as {path}@0.05") from error
    return read_image(Path(path), metres)


def _generated(name: str) -> tuple[str, int] | None:
    match = _GENERATED.fullmatch(name)
    return (match[1], int(match[2])) if match and match[1] in GENERATORS else None


def _split(name: str) -> tuple[str, str]:
    """Path and scale; no scale but of a picture."""
    match = _PICTURE.fullmatch(name)
    return (match[1], match[2]) if match and Path(match[1]).suffix.lower() in PICTURES else (name, "")


def _suffix(name: str) -> str:
    return Path(_split(name)[0]).suffix.lower()
