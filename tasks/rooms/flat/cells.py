"""Walls out of a grid of cells that are occupied or free."""

import math

import numpy as np
from scipy import ndimage

from tasks.errors import TaskError
from tasks.physics import Pose
from tasks.room_geometry.grid import BoolArray
from tasks.rooms.flat.flat_shapes import to_quaternion
from tasks.rooms.flat.rectangles import cover
from tasks.rooms.limits import MAX_OBSTACLES, MAX_WIDTH
from tasks.rooms.room import Obstacle, box

POCKET = 0.2  # m; free cells that no square of this side fits into are no floor
DEPTH = 0.5  # m of solid kept around the floor
ORIGIN = Pose(0.0, 0.0, 0.0)


def make_walls(occupied: BoolArray, cell: float, origin: Pose = ORIGIN) -> tuple[Obstacle, ...]:
    """Boxes in the place of the occupied cells.

    Closed pockets too small for any robot are filled, and solid ground more than DEPTH beyond the floor is left out:
    no robot gets there and no beam, and a map's noise outside its walls would make thousands of boxes.

    Args:
        occupied: (rows, columns), x along the columns and y along the rows.
        cell: its side, metres.
        origin: of the outer corner of cell (0, 0), the grid turned about it by its yaw.

    Raises:
        TaskError: no cell is free, or the grid is too large or takes too many boxes.
    """
    if max(occupied.shape) * cell > MAX_WIDTH:
        raise TaskError(f"a room {max(occupied.shape) * cell:g} m wide is larger than {MAX_WIDTH:g} m")
    solid = _fill_pockets(occupied, cell)
    (top, left), kept = _crop(solid, cell)
    rectangles = cover(kept)
    if len(rectangles) > MAX_OBSTACLES:
        raise TaskError(f"its walls take {len(rectangles):,} boxes, more than {MAX_OBSTACLES:,}: it is too rough")
    edges = (rectangles + np.array([top, left, top, left])) * cell
    centres, halves = (edges[:, 2:] + edges[:, :2]) / 2, (edges[:, 2:] - edges[:, :2]) / 2
    cos, sin, turn = math.cos(origin.yaw), math.sin(origin.yaw), to_quaternion(origin.yaw)
    return tuple(
        box(origin.x + cos * x - sin * y, origin.y + sin * x + cos * y, half_x, half_y, turn, "wall")
        for (y, x), (half_y, half_x) in zip(centres.tolist(), halves.tolist(), strict=True)
    )


def _fill_pockets(occupied: BoolArray, cell: float) -> BoolArray:
    """Occupied cells, and the pieces of free ones without a square of side POCKET."""
    pieces, _ = ndimage.label(~occupied)
    side = max(1, round(POCKET / cell))
    square_fits = ndimage.minimum_filter((~occupied).astype(np.uint8), side, mode="constant", cval=0)
    is_floor = np.zeros(int(pieces.max()) + 1, dtype=bool)
    is_floor[pieces[square_fits > 0]] = True
    is_floor[0] = False
    if not is_floor.any():
        raise TaskError("it has no free floor")
    return np.asarray(~is_floor[pieces])


def _crop(solid: BoolArray, cell: float) -> tuple[tuple[int, int], BoolArray]:
    """Solid cells in the rectangle around the floor and DEPTH beyond it, and the rectangle's first row and column."""
    beyond = math.ceil(DEPTH / cell)
    spans = []
    for axis in (1, 0):
        floor = np.flatnonzero(~solid.all(axis=axis))
        spans.append(slice(max(0, int(floor[0]) - beyond), int(floor[-1]) + 1 + beyond))
    return (spans[0].start, spans[1].start), solid[spans[0], spans[1]]
