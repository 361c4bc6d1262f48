"""Fields of cylinders as the BARN challenge uses them: its proportions and its start and goal, fields of our own."""

from math import pi

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from tasks.errors import TaskError
from tasks.physics import Pose
from tasks.rooms.generators.connected import LEAST_SHARE, MOST_OBSTACLES, TURNING_RADIUS, largest_share
from tasks.rooms.generators.parts import THICKNESS
from tasks.rooms.room import Obstacle, Point, Room, box, cylinder

CELL = 0.15  # m
RADIUS = 0.075  # m
ROWS, COLUMNS = 30, 28  # of the field, between two rows of cylinders that run along y
WEST = -4.425  # m, x of the western row
SOUTH = 5.1  # m, southern edge of the field; 5 m of free floor before it
START: Pose = Pose(-2.25, 3.0, pi / 2)
GOAL: Point = (-2.25, 13.0)

FILL = (0.10, 0.30)  # of the cells, at first
STEPS = (1, 4)  # of the automaton, least and most
LONELY = 2  # a cylinder with fewer neighbours goes
CROWDED = 5  # a free cell with as many is filled

CLEARANCE = TURNING_RADIUS  # m; the robot cannot drive backwards, and would be trapped where it cannot turn
_FINE = 4  # points of the search along a cell
_DIP = 0.0012  # m; so much nearer to a cylinder is a diagonal step's middle than its ends, at most
_EDGE = 4  # cells of free floor before and behind the field in the search
_MOST_DRAWS = 200

Field = npt.NDArray[np.bool_]  # (ROWS, COLUMNS + 2), from the south; its first and last column are the two rows


def draw_cylinders(rng: np.random.Generator) -> Room:
    """Draw a field through which a disc of radius CLEARANCE finds a path; its pair leads from end to end.

    The two rows are cylinders beside the field and boxes beside the free floor, which would need 98 cylinders more.
    """
    for _ in range(_MOST_DRAWS):
        field = _draw_field(rng)
        if _is_passable(field):
            obstacles = (*_build_end(), *_place_cylinders(field))
            if len(obstacles) <= MOST_OBSTACLES and largest_share(obstacles) >= LEAST_SHARE:
                return Room(obstacles, pairs=((START, GOAL),))
    raise TaskError(f"{_MOST_DRAWS} draws gave no field of cylinders with a path through it")


def _draw_field(rng: np.random.Generator) -> Field:
    field = np.ones((ROWS, COLUMNS + 2), dtype=bool)
    inner = field[:, 1:-1]
    inner[:] = rng.random((ROWS, COLUMNS)) < rng.uniform(*FILL)
    for _ in range(int(rng.integers(STEPS[0], STEPS[1] + 1))):
        neighbours = ndimage.convolve(field.astype(np.int8), np.ones((3, 3), dtype=np.int8), mode="constant") - field
        inner[:] = np.where(inner, neighbours[:, 1:-1] >= LONELY, neighbours[:, 1:-1] >= CROWDED)
    return field


def _is_passable(field: Field) -> bool:
    """Whether a path leads from the south to the north, on points a quarter of a cell apart."""
    rows, columns = field.shape
    centres = np.zeros(((rows + 2 * _EDGE) * _FINE, (columns - 1) * _FINE + 1), dtype=bool)
    centres[_EDGE * _FINE : -_EDGE * _FINE : _FINE, ::_FINE] = field
    centres[: _EDGE * _FINE : _FINE, [0, -1]] = True
    distance = ndimage.distance_transform_edt(~centres) * (CELL / _FINE)
    pieces, _ = ndimage.label(distance >= CLEARANCE + RADIUS + _DIP, np.ones((3, 3)))
    return bool(pieces[0, columns * _FINE // 2] == pieces[-1, columns * _FINE // 2])


def _build_end() -> list[Obstacle]:
    """Three walls around the free floor south of the field."""
    east, half = WEST + (COLUMNS + 1) * CELL, SOUTH / 2
    middle = (WEST + east) / 2
    return [
        box(middle, SOUTH - 5.0 - THICKNESS / 2, (east - WEST) / 2 + RADIUS, THICKNESS / 2, name="wall"),
        box(WEST, half, RADIUS, half, name="wall"),
        box(east, half, RADIUS, half, name="wall"),
    ]


def _place_cylinders(field: Field) -> list[Obstacle]:
    places = np.argwhere(field).tolist()
    return [cylinder(WEST + column * CELL, SOUTH + (row + 0.5) * CELL, RADIUS) for row, column in places]
