"""Mazes drawn with characters."""

from itertools import product
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tasks.errors import TaskError
from tasks.physics import Pose
from tasks.room_geometry.grid import BoolArray
from tasks.rooms.flat.cells import make_walls
from tasks.rooms.limits import check_cells, read_bytes, to_length
from tasks.rooms.room import Point, Room

CELL = 1.0  # m, unless the file says otherwise
MAX_PAIRS = 1000
WALLS, FLOOR, START, GOAL = "#1", " .0", "S", "G"


def read_maze(path: Path) -> Room:
    """The maze of a text file: a line for each row of cells, the last one along y = 0.

    # and 1 are walls; space, . and 0 floor; every S is a start, heading along x, to every G, a goal. A first line
    such as `cell 0.5` gives the side of a cell, metres.

    Raises:
        TaskError: the file is missing or too large, or holds another character.
    """
    content = read_bytes(path)
    try:
        cell, lines = _split_lines(content)
        cells = _to_cells(lines)
        walls = make_walls(np.isin(cells, list(WALLS.encode())), cell)
        return Room(walls, *_find_pairs(cells == ord(START), cells == ord(GOAL), cell))
    except TaskError as error:
        raise TaskError(f"{path}: {error}") from error


def _split_lines(content: bytes) -> tuple[float, list[str]]:
    """The side of a cell, and the lines of the maze, top first."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise TaskError("it is not a text in UTF-8") from error
    lines = [line.removesuffix("\r") for line in text.split("\n")]
    cell = CELL
    if lines[0].startswith("cell"):
        cell = to_length(lines.pop(0).removeprefix("cell").strip(), "the side of a cell")
    while lines and not lines[-1].strip():
        lines.pop()
    while lines and not lines[0].strip():
        lines.pop(0)
    if not lines:
        raise TaskError("it holds no maze")
    return cell, lines


def _to_cells(lines: list[str]) -> npt.NDArray[np.uint8]:
    """Codes of the characters: (rows, columns), the lowest row first; floor where a line is short."""
    width = max(map(len, lines))
    check_cells(len(lines), width)
    for number, line in enumerate(lines, 1):
        if wrong := set(line) - set(WALLS + FLOOR + START + GOAL):
            column = min(line.index(each) for each in wrong)
            raise TaskError(
                f"row {number} of the maze has {line[column]!r} in column {column + 1}; it is made of "
                f"# or 1 (wall), space, . or 0 (floor), S (start) and G (goal)"
            )
    cells = np.frombuffer("".join(line.ljust(width) for line in lines).encode(), dtype=np.uint8)
    return cells.reshape(len(lines), width)[::-1]


def _find_pairs(
    starts: BoolArray, goals: BoolArray, cell: float
) -> tuple[tuple[str, ...], tuple[tuple[Pose, Point], ...]]:
    """What was omitted, and every start with every goal, metres."""
    counts = np.count_nonzero(starts), np.count_nonzero(goals)
    if counts[0] * counts[1] > MAX_PAIRS:
        raise TaskError(f"{counts[0]} starts and {counts[1]} goals are more than {MAX_PAIRS} pairs")
    if not all(counts):
        lone = START if counts[0] else GOAL
        return (f"the cells {lone}: a pair takes a start, S, and a goal, G",) if any(counts) else (), ()
    (begins, ends) = ((np.argwhere(found)[:, ::-1] + 0.5) * cell for found in (starts, goals))
    return (), tuple(
        (Pose(x, y, 0.0), (to_x, to_y)) for (x, y), (to_x, to_y) in product(begins.tolist(), ends.tolist())
    )
