"""Bounds on the files of rooms, so that a broken or hostile one costs little time and memory."""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tasks.errors import TaskError
from tasks.rooms.room import Obstacle

MAX_BYTES = 20_000_000
MAX_CELLS = 16_000_000  # 4000 × 4000
MAX_OBSTACLES = 20_000
MIN_LENGTH, MAX_WIDTH = 1e-4, 500.0  # m
MAX_AREA = 40_000  # m² of the rectangle around a room: grids over it take half a gigabyte
MAX_COORDINATE = 1e6  # m; beyond it floor grids and pictures lose millimetres


def read_bytes(path: Path, most: int = MAX_BYTES) -> bytes:
    """The content of a regular file.

    Raises:
        TaskError: there is no such file, it cannot be read, or it is longer than `most` bytes.
    """
    try:
        if not path.exists():
            raise TaskError(f"there is no file {path}")
        if not path.is_file():  # a pipe would wait for ever
            raise TaskError(f"{path} is not a file")
        with path.open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise TaskError(f"{path} cannot be read: {error}") from error
    if len(content) > most:
        raise TaskError(f"{path} is larger than {most / 1e6:g} MB")
    return content


def to_number(value: object, name: str, low: float = -MAX_COORDINATE, high: float = MAX_COORDINATE) -> float:
    """A finite number in a range, both ends included.

    Raises:
        TaskError: it is not a number, or out of range; `name` says in the message what it is.
    """
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        raise TaskError(f"{name} must be a number, not {_short(value)}") from error
    if not (math.isfinite(number) and low <= number <= high):
        raise TaskError(f"{name} must be from {low:g} to {high:g}, not {number:g}")
    return number


def to_length(value: object, name: str) -> float:
    """A number from MIN_LENGTH to MAX_WIDTH, metres; TaskError for another."""
    return to_number(value, name, MIN_LENGTH, MAX_WIDTH)


def check_cells(rows: int, columns: int) -> None:
    """TaskError where a room has too many cells."""
    if rows * columns > MAX_CELLS:
        raise TaskError(f"{rows} × {columns} cells are more than {MAX_CELLS:,}")


def check_obstacles(obstacles: Sequence[Obstacle]) -> None:
    """TaskError where obstacles are too many or too far apart."""
    if len(obstacles) > MAX_OBSTACLES:
        raise TaskError(f"{len(obstacles):,} obstacles are more than {MAX_OBSTACLES:,}")
    width = max(np.ptp([obstacle.position[:2] for obstacle in obstacles], axis=0)) if obstacles else 0.0
    if width > MAX_WIDTH:
        raise TaskError(f"a room {width:g} m wide is larger than {MAX_WIDTH:g} m")


def _short(value: object) -> str:
    text = repr(value) if isinstance(value, str | int | float) else type(value).__name__
    return text if len(text) <= 40 else f"{text[:40]}…"
